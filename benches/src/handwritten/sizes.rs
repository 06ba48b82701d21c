//! The sizes of the one robot that the code is written for.

pub(super) const COLUMNS: usize = 6;
pub(super) const NODES: usize = 36;
pub(super) const EDGES: usize = 110;
pub(super) const HIDDEN: usize = 32;
/// Numbers of a state: x, y, x velocity, y velocity of all nodes.
pub(super) const STATE: usize = 4 * NODES;
/// Inputs of the folded controller: the state, sine and cosine.
pub(super) const SENSED: usize = STATE + 2;
/// Nodes and edges to whole registers of 16 numbers.
pub(super) const NODE_PLACES: usize = 48;
pub(super) const EDGE_PLACES: usize = 112;
/// Places for outputs where only some edges strain.
pub(super) const FEW: usize = 32;
