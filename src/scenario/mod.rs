//! Scenarios: TOML text in, a checked [`Scenario`] out. Sees the plain choices of the other rooms, no numerics.
