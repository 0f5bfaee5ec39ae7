//! `[units]`: what the numbers of a scenario are meant in. Echoed beside results, never converted.

use serde::{Deserialize, Serialize};

/// The declared units, as written.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Units {
    /// Of lengths and displacements.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<String>,
    /// Of forces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<String>,
    /// Of stresses, moduli and tractions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress: Option<String>,
    /// Of energies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<String>,
    /// Of masses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<String>,
    /// Of times, in accelerations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
}
