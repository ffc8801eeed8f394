//! Which bodies and colliders meet each other.

use crate::scene::{Body, Collider};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Some of the layers 0 to 31, a bit each; in a scene a list of their numbers.
///
/// ```
/// use taffeta::scene::LayerMask;
///
/// assert_eq!(LayerMask::of([0, 3]), LayerMask(0b1001));
/// assert_eq!(LayerMask::NONE.numbers().count(), 0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LayerMask(pub u32);

impl LayerMask {
    /// All of them.
    pub const ALL: Self = Self(u32::MAX);
    /// None of them.
    pub const NONE: Self = Self(0);

    /// Those of these numbers; there are none from 32 on.
    pub fn of(numbers: impl IntoIterator<Item = u32>) -> Self {
        Self(numbers.into_iter().filter_map(|number| 1_u32.checked_shl(number)).fold(0, |all, bit| all | bit))
    }

    /// Their numbers, ascending.
    pub fn numbers(self) -> impl Iterator<Item = u32> {
        (0..u32::BITS).filter(move |number| self.0 >> number & 1 == 1)
    }

    /// Whether all are among them.
    fn is_all(&self) -> bool {
        *self == Self::ALL
    }
}

impl Default for LayerMask {
    fn default() -> Self {
        Self::ALL
    }
}

impl Serialize for LayerMask {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.numbers())
    }
}

impl<'de> Deserialize<'de> for LayerMask {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(Numbers)
    }
}

/// Reads a list of numbers.
struct Numbers;

impl<'de> Visitor<'de> for Numbers {
    type Value = LayerMask;

    fn expecting(&self, words: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        words.write_str("a list of layers, numbers from 0 to 31")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut numbers: A) -> Result<LayerMask, A::Error> {
        let mut all = LayerMask::NONE;
        while let Some(Layer(bit)) = numbers.next_element()? {
            all.0 |= bit;
        }
        Ok(all)
    }
}

/// The bit of a layer.
struct Layer(u32);

impl<'de> Deserialize<'de> for Layer {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_i64(Number)
    }
}

/// Reads the number of a layer.
struct Number;

impl Visitor<'_> for Number {
    type Value = Layer;

    fn expecting(&self, words: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        words.write_str("a whole number from 0 to 31")
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Layer, E> {
        let bit = u32::try_from(number).ok().and_then(|number| 1_u32.checked_shl(number));
        bit.map(Layer).ok_or_else(|| E::invalid_value(Unexpected::Signed(number), &self))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Layer, E> {
        self.visit_i64(i64::try_from(number).unwrap_or(i64::MAX))
    }
}

impl JsonSchema for LayerMask {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "LayerMask".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Some of the layers 0 to 31.",
            "type": "array",
            "items": { "type": "integer", "minimum": 0, "maximum": 31 },
        })
    }
}

/// In which layers a body or a collider is, and those of which it meets. Two meet each other if each is in a layer that the other
/// meets. A body always meets itself; whether it collides with itself is said by its
/// [`SelfCollision`](crate::scene::SelfCollision).
///
/// ```
/// use taffeta::scene::{Body, Collider, Layers, Mass, Mesh};
///
/// // A cape meets the table, and not the capsule, which is for the shirt alone.
/// let capsule = Collider::capsule([0.0; 3], [0.0, 1.0, 0.0], 0.2).layers(Layers::new([1], [1]));
/// let table = Collider::cuboid([0.0; 3], [0.5; 3]);
/// let cape = Body::cloth("cape", Mesh::grid(9, 9, [1.0, 1.0])).with_mass(Mass::Area(0.2)).layers(Layers::new([2], 0..32));
/// assert!(cape.layers.meets(&table.layers) && !cape.layers.meets(&capsule.layers));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Layers {
    /// The layers that it is in: all of 0 to 31 if nothing is said.
    #[serde(skip_serializing_if = "LayerMask::is_all")]
    pub memberships: LayerMask,
    /// The layers that it meets: all of 0 to 31 if nothing is said.
    #[serde(skip_serializing_if = "LayerMask::is_all")]
    pub filter: LayerMask,
}

impl Layers {
    /// By the numbers of the layers that it is in, and of those that it meets.
    pub fn new(memberships: impl IntoIterator<Item = u32>, filter: impl IntoIterator<Item = u32>) -> Self {
        Self { memberships: LayerMask::of(memberships), filter: LayerMask::of(filter) }
    }

    /// Whether what is in these layers and what is in others meet.
    pub fn meets(&self, other: &Self) -> bool {
        self.memberships.0 & other.filter.0 != 0 && other.memberships.0 & self.filter.0 != 0
    }

    /// Whether nothing is said.
    pub(crate) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

impl Body {
    /// Sets which bodies and colliders it meets.
    pub fn layers(mut self, layers: Layers) -> Self {
        self.layers = layers;
        self
    }
}

impl Collider {
    /// Sets which bodies it meets.
    pub fn layers(mut self, layers: Layers) -> Self {
        self.layers = layers;
        self
    }
}
