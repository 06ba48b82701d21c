//! Dense layers: the product of a matrix and a vector, its layout in memory, and its derivatives.

mod aligned;
mod epilogue;
mod panels;
mod tiles;
mod product;
mod outer;
mod layer;

pub(crate) use aligned::Aligned;
pub(crate) use layer::DenseLayer;
pub use layer::Layer;
