//! The hand at rest: bones, skin and triangles.

use std::path::Path;

use super::super::input::{self, Error, Tokens};
use super::transform::Affine;

/// A hand model. Vertices are stored by coordinate and weights by bone, padded to whole registers.
#[derive(Clone, Debug)]
pub struct HandModel {
    pub(super) bones: Vec<Bone>,
    pub(super) vertices: [Vec<f64>; 3],
    /// Per bone, its weight for every vertex.
    pub(super) weights: Vec<Vec<f64>>,
    /// The vertices of each triangle.
    pub triangles: Vec<[usize; 3]>,
    /// The number of vertices, padding left out.
    pub len: usize,
    /// Whether x is the other way round.
    pub(super) mirrored: bool,
}

/// A bone at rest.
#[derive(Clone, Copy, Debug)]
pub struct Bone {
    /// Comes before its children; the root has none.
    pub parent: Option<usize>,
    /// The pose relative to the parent.
    pub relative: Affine<f64>,
    /// The inverse of the pose at rest.
    pub inverse_rest: Affine<f64>,
}

/// A wrist, five fingers of four bones, a forearm.
pub const BONES: usize = 22;
/// At least as many as any register has lanes.
const PADDING: usize = 16;
/// Numbers of a vertex that the model holds and this objective does not use.
const UNUSED: usize = 5;

impl HandModel {
    /// Reads `bones.txt`, `vertices.txt` and `triangles.txt` of a folder.
    pub(super) fn read(folder: &Path) -> Result<Self, Error> {
        let bones = lines(&folder.join("bones.txt"), bone)?;
        let path = folder.join("vertices.txt");
        let rows = lines(&path, vertex)?;
        let len = rows.len();
        let triangle = |tokens: &mut Tokens| {
            let corners = [tokens.next()?, tokens.next()?, tokens.next()?];
            if corners.iter().any(|&corner: &usize| corner >= len) {
                return Err(tokens.error(format!("triangle {corners:?} names a missing vertex")));
            }
            Ok(corners)
        };
        let path = folder.join("bones.txt");
        let triangles = lines(&folder.join("triangles.txt"), triangle)?;
        Self::new(bones, &rows, triangles, false).ok_or_else(|| Error::Malformed {
            path,
            what: format!("a hand has {BONES} bones, each after its parent"),
        })
    }

    /// A model, from its bones, vertices with the bones that they are bound to, and triangles. `None` if
    /// the bones are not those of a hand.
    pub fn new(
        bones: Vec<Bone>,
        vertices: &[Vertex],
        triangles: Vec<[usize; 3]>,
        mirrored: bool,
    ) -> Option<Self> {
        let forward = |(i, bone): (usize, &Bone)| bone.parent.is_none_or(|parent| parent < i);
        if bones.len() != BONES || !bones.iter().enumerate().all(forward) {
            return None;
        }
        let len = vertices.len();
        let column = |i: usize| padded(vertices.iter().map(|(place, _)| place[i]));
        let mut weights = vec![vec![0.0; len.next_multiple_of(PADDING)]; bones.len()];
        for (vertex, (_, named)) in vertices.iter().enumerate() {
            for &(bone, weight) in named {
                weights[bone][vertex] = weight;
            }
        }
        Some(Self {
            vertices: [column(0), column(1), column(2)],
            triangles,
            bones,
            weights,
            len,
            mirrored,
        })
    }
}

/// Reads each line of a file, fields separated by `:`.
fn lines<T>(
    path: &Path,
    mut line: impl FnMut(&mut Tokens) -> Result<T, Error>,
) -> Result<Vec<T>, Error> {
    let text = input::read(path)?.replace(':', " ");
    let read = |text| {
        let mut tokens = Tokens::new(path, text);
        let item = line(&mut tokens)?;
        tokens.end()?;
        Ok(item)
    };
    let rows = text.lines().filter(|line| !line.trim().is_empty());
    rows.map(read).collect()
}

fn bone(tokens: &mut Tokens) -> Result<Bone, Error> {
    let _name: String = tokens.next()?;
    let parent: i64 = tokens.next()?;
    Ok(Bone {
        parent: usize::try_from(parent).ok(),
        relative: affine(tokens)?,
        inverse_rest: affine(tokens)?,
    })
}

fn affine(tokens: &mut Tokens) -> Result<Affine<f64>, Error> {
    let matrix = [tokens.array()?, tokens.array()?, tokens.array()?];
    let last: [f64; 4] = tokens.array()?;
    if last != [0.0, 0.0, 0.0, 1.0] {
        return Err(tokens.error("the last row of a transformation is 0 0 0 1"));
    }
    Ok(Affine(matrix))
}

/// A place, and the bones that it is bound to with their weights.
pub type Vertex = ([f64; 3], Vec<(usize, f64)>);

fn vertex(tokens: &mut Tokens) -> Result<Vertex, Error> {
    let place = tokens.array()?;
    tokens.array::<UNUSED>()?;
    let count: usize = tokens.next()?;
    let mut weight = || {
        let bone: usize = tokens.next()?;
        if bone >= BONES {
            return Err(tokens.error(format!("a hand has no bone {bone}")));
        }
        Ok((bone, tokens.next()?))
    };
    let weights: Result<_, _> = (0..count).map(|_| weight()).collect();
    Ok((place, weights?))
}

fn padded(numbers: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut numbers: Vec<f64> = numbers.collect();
    numbers.resize(numbers.len().next_multiple_of(PADDING), 0.0);
    numbers
}
