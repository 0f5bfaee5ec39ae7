//! The keys of a scenario as written: optional fields with their spans, nothing checked but names and types.

use super::actions::{Fixed, RawStiffness};
use super::spanned::Spanned;
use super::wanted::{RawBound, RawExpectation, RawProbe};
use super::{Midside, fields, shapes};
use crate::adapt::options::Estimator;
use crate::fem::options::{Element, ExactSolution, Field, HexElement, Method, Total};
use crate::output::options::{Compression, FieldName, HexCells, Units};
use crate::subdiv::options::{Boundary, CatmullClark, Mode, Objective, Octahedra, QualityMeasure, Scheme, SmoothBasis};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, de};
use std::{borrow::Cow, collections::BTreeMap, fmt, marker::PhantomData, ops::Range};

/// A TOML table with its span. Unlike a derived struct it refuses an array.
#[derive(Debug)]
pub(super) struct Table<T> {
    pub span: Range<usize>,
    pub value: T,
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Table<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let spanned = Spanned::<TableOnly<T>>::deserialize(deserializer)?;
        Ok(Self { span: spanned.span(), value: spanned.into_inner().0 })
    }
}

#[derive(Debug)]
struct TableOnly<T>(T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for TableOnly<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(TableVisitor(PhantomData)).map(Self)
    }
}

struct TableVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> de::Visitor<'de> for TableVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table")
    }

    fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::deserialize(de::value::MapAccessDeserializer::new(map))
    }
}

pub(super) type Number = Spanned<f64>;
pub(super) type Integer = Spanned<i64>;
pub(super) type Text = Spanned<String>;
/// Three numbers, once checked (an array type would drop a fourth without a word).
pub(super) type Vector = Spanned<Vec<f64>>;
pub(super) type Named<T> = BTreeMap<String, Table<T>>;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Scenario of Subsolid")]
pub(super) struct RawScenario {
    pub title: Option<String>,
    pub description: Option<String>,
    pub mesh: Option<Table<RawMesh>>,
    pub features: Option<Table<RawFeatures>>,
    pub materials: Option<Named<RawMaterial>>,
    pub supports: Option<Named<RawSupport>>,
    pub loads: Option<Named<RawLoad>>,
    pub analysis: Option<Table<RawAnalysis>>,
    pub refine: Option<Table<RawRefine>>,
    pub adapt: Option<Table<RawAdapt>>,
    pub solver: Option<Table<RawSolver>>,
    pub output: Option<Table<RawOutput>>,
    pub published: Option<Table<RawPublished>>,
    pub units: Option<Table<Units>>,
    pub quantities: Option<Named<RawQuantity>>,
    pub probes: Option<Named<RawProbe>>,
    pub expect: Option<Named<RawExpectation>>,
    pub exact: Option<Table<RawExact>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMesh {
    pub file: Option<Text>,
    pub midside: Option<Spanned<Midside>>,
    pub merge: Option<Spanned<bool>>,
    #[serde(rename = "box")]
    pub brick: Option<Table<RawBrick>>,
    #[serde(rename = "l-prism")]
    pub l_prism: Option<Table<shapes::RawUnits>>,
    pub fichera: Option<Table<shapes::RawUnits>>,
    pub cylinder: Option<Table<shapes::RawCylinder>>,
    pub tube: Option<Table<shapes::RawTube>>,
    #[serde(rename = "sphere-shell")]
    pub sphere_shell: Option<Table<shapes::RawShell>>,
    #[serde(rename = "plate-with-hole")]
    pub plate_with_hole: Option<Table<shapes::RawPlate>>,
    pub le10: Option<Table<shapes::RawLe10>>,
    pub prism: Option<Table<shapes::RawPrism>>,
}

impl RawMesh {
    /// Whether nodes at the same place are to be made one.
    pub(super) fn merges(&self) -> bool {
        self.merge.as_ref().is_some_and(|merge| *merge.get_ref())
    }
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBrick {
    pub size: Vector,
    pub cells: Spanned<Vec<i64>>,
    #[serde(rename = "element")]
    pub _element: Option<CellShape>,
}

/// Shape of generated cells.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum CellShape {
    Tet,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFeatures {
    pub angle: Option<Number>,
    pub edges: Option<Vec<Spanned<Vec<u32>>>>,
    pub corners: Option<Vec<u32>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMaterial {
    pub youngs_modulus: Number,
    pub poissons_ratio: Number,
    pub density: Option<Number>,
    pub group: Option<Text>,
}

/// A table that holds the keys of a selector beside keys of its own.
macro_rules! selector_table {
    ($name:ident { $($field:ident: $type:ty),* }) => {
        #[derive(Debug, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub(super) struct $name {
            $(pub $field: Option<$type>,)*
            pub group: Option<Text>,
            pub plane: Option<Table<RawPlane>>,
            #[serde(rename = "box")]
            pub brick: Option<Table<RawBox>>,
            pub sphere: Option<Table<RawSphere>>,
            pub cylinder: Option<Table<RawCylinder>>,
            pub normal: Option<Table<RawNormal>>,
            pub all: Option<Spanned<Vec<Table<RawSelector>>>>,
            pub any: Option<Spanned<Vec<Table<RawSelector>>>>,
            pub not: Option<Box<Table<RawSelector>>>,
        }
    };
}

/// The way from such a table to the keys of its selector.
macro_rules! selector_of {
    ($name:ident) => {
        impl From<$name> for RawSelector {
            fn from(table: $name) -> Self {
                let $name { group, plane, brick, sphere, cylinder, normal, all, any, not, .. } = table;
                Self { group, plane, brick, sphere, cylinder, normal, all, any, not }
            }
        }
    };
}

selector_table!(RawSelector {});
selector_table!(RawSupport {
    meet: Spanned<Vec<Table<RawSelector>>>,
    fix: Spanned<Fixed>,
    symmetry: Spanned<bool>,
    displacement: Table<RawDisplacement>,
    weak: Spanned<bool>,
    spring: Spanned<RawStiffness>
});
selector_table!(RawLoad {
    traction: fields::Vector,
    pressure: fields::Scalar,
    force: Vector,
    point: Vector,
    body_force: fields::Vector,
    gravity: Vector
});
selector_table!(RawQuantity {
    average: Spanned<Field>,
    maximum: Spanned<Field>,
    value: Spanned<Field>,
    point: Vector,
    total: Spanned<Total>,
    reaction: Text,
    component: Spanned<Axis>,
    region: Text,
    within: Table<RawWithin>
});
selector_table!(RawMove { displacement: Table<RawDisplacement>, points: Spanned<Vec<u32>> });
selector_table!(RawExact { solution: ExactSolution });
selector_of!(RawMove);
selector_of!(RawExact);
selector_of!(RawQuantity);
selector_of!(RawSupport);
selector_of!(RawLoad);

/// A coordinate direction.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Axis {
    X,
    Y,
    Z,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawDisplacement {
    pub x: Option<fields::Scalar>,
    pub y: Option<fields::Scalar>,
    pub z: Option<fields::Scalar>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPlane {
    pub normal: Vector,
    pub offset: Number,
    pub tolerance: Option<Number>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBox {
    pub min: Vector,
    pub max: Vector,
    pub tolerance: Option<Number>,
}

/// A box inside the part.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawWithin {
    pub min: Vector,
    pub max: Vector,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSphere {
    pub center: Vector,
    pub radius: Number,
    pub tolerance: Option<Number>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCylinder {
    pub point: Vector,
    pub axis: Vector,
    pub radius: Number,
    pub tolerance: Option<Number>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawNormal {
    pub direction: Vector,
    pub angle: Number,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawAnalysis {
    pub element: Option<Spanned<AnyElement>>,
    pub masks: Option<Spanned<CatmullClark>>,
    pub points: Option<Integer>,
    pub splits: Option<Integer>,
    pub interpolate: Option<Spanned<bool>>,
    pub smooth: Option<Table<RawSmooth>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSmooth {
    pub steps: Option<Integer>,
    pub octahedra: Option<Octahedra>,
    pub basis: Option<SmoothBasis>,
}

/// The finite element, of tetrahedra or of hexahedra.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum AnyElement {
    Tet4,
    Tet10,
    Hex8,
    Hex20,
    Hex27,
    CatmullClark,
    #[serde(rename = "catmull-clark+")]
    CatmullClarkPlus,
}

impl AnyElement {
    /// That of tetrahedra, or that of hexahedra.
    pub fn kind(self) -> Result<Element, HexElement> {
        match self {
            Self::Tet4 => Ok(Element::Tet4),
            Self::Tet10 => Ok(Element::Tet10),
            Self::Hex8 => Err(HexElement::Hex8),
            Self::Hex20 => Err(HexElement::Hex20),
            Self::Hex27 => Err(HexElement::Hex27),
            Self::CatmullClark => Err(HexElement::CatmullClark),
            Self::CatmullClarkPlus => Err(HexElement::CatmullClarkPlus),
        }
    }
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRefine {
    pub scheme: Option<Spanned<Scheme>>,
    pub strategy: Option<Spanned<super::Strategy>>,
    pub steps: Option<Integer>,
    pub boundary: Option<Boundary>,
    pub optimise: Option<Table<RawOptimise>>,
    pub stop: Option<Table<RawStop>>,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawOptimise {
    pub mode: Option<Mode>,
    pub objective: Option<Objective>,
    pub directions: Option<Spanned<bool>>,
    pub measure: Option<Spanned<QualityMeasure>>,
    pub passes: Option<Integer>,
    pub target_angle: Option<Number>,
    pub valence_limit: Option<Integer>,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawStop {
    pub relative_error: Option<Number>,
    pub quantity_error: Option<Spanned<RawBound>>,
    pub max_cells: Option<Integer>,
    pub max_memory: Option<Spanned<Bytes>>,
    pub seconds: Option<Number>,
}

/// A number of bytes: an integer, or a string such as "2 GiB".
#[derive(Debug, Clone, Copy)]
pub(super) struct Bytes(pub u64);

impl<'de> Deserialize<'de> for Bytes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(BytesVisitor)
    }
}

impl JsonSchema for Bytes {
    fn schema_name() -> Cow<'static, str> {
        "Bytes".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": ["integer", "string"], "description": "A number of bytes, or a string such as \"2 GiB\"." })
    }
}

struct BytesVisitor;

impl de::Visitor<'_> for BytesVisitor {
    type Value = Bytes;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number of bytes such as 2000000000 or \"2 GiB\"")
    }

    fn visit_i64<E: de::Error>(self, bytes: i64) -> Result<Bytes, E> {
        u64::try_from(bytes).map(Bytes).map_err(|_| E::invalid_value(de::Unexpected::Signed(bytes), &self))
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Bytes, E> {
        parse_bytes(text).map(Bytes).ok_or_else(|| E::invalid_value(de::Unexpected::Str(text), &self))
    }
}

/// Reads "2 GiB", "500MB", "1.5 TiB", "4096".
fn parse_bytes(text: &str) -> Option<u64> {
    const UNITS: [(&str, u64); 10] = [
        ("", 1),
        ("B", 1),
        ("kB", 1000),
        ("MB", 1_000_000),
        ("GB", 1_000_000_000),
        ("TB", 1_000_000_000_000),
        ("KiB", 1 << 10),
        ("MiB", 1 << 20),
        ("GiB", 1 << 30),
        ("TiB", 1 << 40),
    ];
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = &text[digits.len()..];
    let (_, scale) = UNITS.iter().find(|(name, _)| name.eq_ignore_ascii_case(unit))?;
    let bytes = digits.trim().parse::<f64>().ok()? * *scale as f64;
    (bytes.is_finite() && bytes >= 0.0).then_some(bytes as u64)
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawAdapt {
    pub estimator: Option<Estimator>,
    pub marking: Option<Table<RawMarking>>,
    pub grow: Option<Integer>,
    pub goal: Option<Text>,
}

impl RawAdapt {
    /// Whether it says how to select cells.
    pub(super) fn steers(&self) -> bool {
        self.estimator.is_some() || self.marking.is_some() || self.grow.is_some()
    }
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMarking {
    pub doerfler: Option<Number>,
    pub maximum: Option<Number>,
    pub fraction: Option<Number>,
    pub threshold: Option<Number>,
    pub look_ahead: Option<Number>,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSolver {
    pub method: Option<Method>,
    pub tolerance: Option<Number>,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawOutput {
    pub vtk: Option<bool>,
    pub report: Option<bool>,
    pub fields: Option<Vec<FieldName>>,
    pub compression: Option<Compression>,
    pub hexahedra: Option<Spanned<HexCells>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPublished {
    pub source: String,
    pub steps: Vec<Table<RawPublishedStep>>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPublishedStep {
    pub label: String,
    pub cells: Integer,
    pub milliseconds: Number,
    pub error: Number,
}

#[cfg(test)]
mod tests {
    use super::parse_bytes;

    #[test]
    fn bytes_are_read_with_decimal_and_binary_units() {
        assert_eq!(parse_bytes("2 GiB"), Some(2 << 30));
        assert_eq!(parse_bytes("1.5kb"), Some(1500));
        assert_eq!(parse_bytes("4096"), Some(4096));
        assert_eq!(parse_bytes("2 GiBs"), None);
        assert_eq!(parse_bytes("-1 MB"), None);
        assert_eq!(parse_bytes("GiB"), None);
    }
}
