//! Vectors in files: an array of `D` numbers.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::vector::Vector;

impl<T, const D: usize> Serialize for Vector<T, D>
where
    [T; D]: Serialize,
{
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<'de, T, const D: usize> Deserialize<'de> for Vector<T, D>
where
    [T; D]: Deserialize<'de>,
{
    fn deserialize<A: Deserializer<'de>>(deserializer: A) -> Result<Self, A::Error> {
        Deserialize::deserialize(deserializer).map(Self)
    }
}
