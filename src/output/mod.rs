//! What people and other programs read: VTK files, reports, tables, plots.
