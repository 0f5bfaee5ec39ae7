//! Trials: changes that can be taken back.

use super::{CellTag, Face, Solid};
use glam::DVec3;

/// One change, with what is needed to take it back.
#[derive(Debug, Clone, Copy)]
pub(super) enum Change {
    CellAdded(u32),
    /// With its stamp.
    CellRemoved([u32; 4], CellTag, u32),
    FaceAdded([u32; 3]),
    FaceRemoved(Face),
    Moved(u32, DVec3),
    /// A cell at a moved vertex, with its minimum sine and stamp.
    Reshaped(u32, f64, u32),
}

/// The changes of a trial.
#[derive(Debug, Default)]
pub(super) struct Journal {
    changes: Vec<Change>,
    points: usize,
    open: bool,
}

impl Journal {
    /// Whether a trial is open.
    pub(super) fn is_open(&self) -> bool {
        self.open
    }

    /// Notes a change if a trial is open.
    pub(super) fn note(&mut self, change: Change) {
        if self.open {
            self.changes.push(change);
        }
    }
}

impl Solid {
    /// Notes that `v` is about to move.
    pub(super) fn note_move(&mut self, v: u32) {
        if self.journal.is_open() {
            self.journal.note(Change::Moved(v, self.points[v as usize]));
            for &t in &self.cells_at[v as usize] {
                self.journal.note(Change::Reshaped(t, self.sines[t as usize], self.stamps[t as usize]));
            }
        }
    }

    /// Starts a trial, in a new period of the clock. During a trial creases must not change.
    pub(in crate::subdiv) fn begin(&mut self) {
        self.tick();
        self.journal.changes.clear();
        self.journal.points = self.points.len();
        self.journal.open = true;
    }

    /// Cells made or reshaped in the open trial that still exist, each at least once.
    pub(in crate::subdiv) fn cells_in_trial(&self) -> Vec<u32> {
        let mut cells: Vec<u32> = Vec::new();
        for change in &self.journal.changes {
            match *change {
                Change::CellAdded(t) => cells.push(t),
                Change::Moved(v, _) => cells.extend(self.cells_at(v)),
                _ => {}
            }
        }
        cells.retain(|&t| self.tets[t as usize][0] != super::DEAD);
        cells
    }

    /// Ends the trial and keeps its changes.
    pub(in crate::subdiv) fn keep(&mut self) {
        self.journal.open = false;
    }

    /// Ends the trial and takes its changes back.
    pub(in crate::subdiv) fn take_back(&mut self) {
        self.journal.open = false;
        let changes = std::mem::take(&mut self.journal.changes);
        for change in changes.iter().rev() {
            match *change {
                Change::CellAdded(t) => {
                    self.remove_cell(t);
                }
                Change::CellRemoved(tet, tag, stamp) => {
                    let t = self.add_cell(tet, tag);
                    self.stamps[t as usize] = stamp;
                }
                Change::FaceAdded(vertices) => {
                    self.remove_face(vertices);
                }
                Change::FaceRemoved(face) => self.add_face(face),
                Change::Moved(v, p) => self.points[v as usize] = p,
                Change::Reshaped(t, sine, stamp) => {
                    (self.sines[t as usize], self.stamps[t as usize]) = (sine, stamp);
                }
            }
        }
        self.journal.changes = changes;
        let count = self.journal.points;
        let kept = self.transfer.len() + count - self.points.len();
        self.transfer.truncate(kept);
        self.points.truncate(count);
        self.cells_at.truncate(count);
        self.faces_at.truncate(count);
        self.pinned.truncate(count);
    }
}
