//! What cells of one class share.

use super::HexSpace;
use std::borrow::Cow;
use std::sync::OnceLock;

/// Something of each class of cells, made when it is first asked for and kept if several cells share it: on meshes where no
/// ring is like another, tables of all cells would take gigabytes.
#[derive(Debug)]
pub(super) struct Shared<T>(Vec<OnceLock<T>>);

impl<T: Clone> Shared<T> {
    pub fn new(space: &HexSpace<'_>) -> Self {
        Self((0..space.classes()).map(|_| OnceLock::new()).collect())
    }

    /// That of a class, which `make` makes.
    pub fn of(&self, space: &HexSpace<'_>, class: usize, make: impl FnOnce() -> T) -> Cow<'_, T> {
        if space.is_shared(class) { Cow::Borrowed(self.0[class].get_or_init(make)) } else { Cow::Owned(make()) }
    }
}
