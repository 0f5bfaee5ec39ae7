//! Tables for people: the steps of a run, and global against adaptive refinement in the shape of Burkhart, Hamann and
//! Umlauf 2011, Figure 6.

mod book;
mod quantities;
mod variants;

pub use book::book;
pub use quantities::{expectations, quantities, true_errors};
pub use variants::variants;

use super::compare::{EqualError, Ratios};
use super::options::{Published, PublishedStep, Units};
use super::report::{PhaseSeconds, Report, StepRecord};
use comfy_table::{Cell, CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, Table, Width, presets};

/// Columns of a terminal that text fits into.
pub const COLUMNS: u16 = 80;

/// The steps of a run as two tables, what was computed and what it cost.
#[must_use]
pub fn steps(records: &[StepRecord]) -> String {
    let mut results = table(
        "step|cells|unknowns|relative\nerror %|mean\nerror|mean sq.\nerror|strain\nenergy|largest\ndispl.|worst\nangle",
    );
    let mut costs = table("step|refine|assemble|solve|estimate|mark|write|total s");
    for r in records {
        results.add_row([
            r.step.to_string(),
            count(r.mesh.cells),
            count(r.free_dofs),
            percent(r.error.relative),
            figures(r.error.normalised_mean, 3),
            figures(r.error.normalised_mean_square, 3),
            figures(r.strain_energy, 6),
            figures(r.max_displacement, 4),
            format!("{:.1}", r.quality.worst),
        ]);
        let PhaseSeconds { refine, assemble, solve, estimate, mark, write, total } = r.seconds;
        let mut row = vec![r.step.to_string()];
        row.extend([refine, assemble, solve, estimate, mark, write, total].map(seconds));
        costs.add_row(row);
    }
    format!("{}\n{ERRORS}\n\nSeconds\n{}\n", text(results), text(costs))
}

/// The declared units in a line; nothing if there are none.
#[must_use]
pub fn units(units: &Units) -> String {
    let list: Vec<String> = units.declared().iter().map(|(name, unit)| format!("{name} {unit}")).collect();
    if list.is_empty() { String::new() } else { format!("units: {}\n", list.join(", ")) }
}

/// The force of each support at a step, and their sum, which is minus that of the loads but for the solver's residual.
#[must_use]
pub fn reactions(record: &StepRecord) -> String {
    let mut rows = table("reactions|x|y|z");
    let mut row = |name: &str, force: [f64; 3]| {
        let mut cells = vec![name.to_owned()];
        cells.extend(force.map(|f| figures(f, 6)));
        rows.add_row(cells);
    };
    let mut total = [0.0; 3];
    for (name, force) in &record.reactions {
        row(name, *force);
        total.iter_mut().zip(force).for_each(|(sum, f)| *sum += f);
    }
    row("sum", total);
    text(rows) + "\n"
}

/// One line for a step just finished.
#[must_use]
pub fn step_line(r: &StepRecord) -> String {
    format!(
        "step {}: {} cells, {} unknowns, relative error {} %, strain energy {}, {} s",
        r.step,
        count(r.mesh.cells),
        count(r.free_dofs),
        percent(r.error.relative),
        figures(r.strain_energy, 6),
        seconds(r.seconds.total)
    )
}

/// The comparison: all steps of both runs, the ratios at equal steps and at equal error, and the published figures beside
/// ours if there are any.
#[must_use]
pub fn comparison(global: &Report, adaptive: &Report, ratios: &Ratios, published: Option<&Published>) -> String {
    let rows = rows(global, adaptive);
    let mut out = format!("{}\n{ERRORS}\n\nSeconds\n{}\n", text(meshes(&rows)), text(phases(&rows)));
    out += &format!("\nGlobal over adaptive at equal steps\n{}\n", text(equal_steps(global, adaptive, ratios)));
    out += &format!("\n{}\n", equal_error(&ratios.equal_error));
    if let Some(published) = published {
        out += &format!("\nBeside {}\n{}\n", published.source, text(beside(&rows, published)));
        out += "Our milliseconds: refine + assemble + solve. Where the source does not say how it normalises its error,\n\
                our two columns are reconstructions.\n";
        for line in factors(&rows, published) {
            out += &format!("{line}\n");
        }
    }
    out
}

/// How the error columns are defined.
const ERRORS: &str = "\
relative error: eta / sqrt(2 energy + eta^2), eta^2 = sum of eta_K^2 over the cells
mean, mean sq.: mean of eta_K and of eta_K^2 over their maxima at step 0
worst angle: minimum dihedral angle in degrees";

/// The label of each mesh and its record: the common base, then the steps of each run.
fn rows<'a>(global: &'a Report, adaptive: &'a Report) -> Vec<(String, &'a StepRecord)> {
    let base = adaptive.steps.first().map(|r| ("base".to_owned(), r));
    let run = |name: &'static str, report: &'a Report| {
        report.steps.iter().skip(1).map(move |r| (format!("{name} {}", r.step), r))
    };
    base.into_iter().chain(run("adaptive", adaptive)).chain(run("global", global)).collect()
}

fn meshes(rows: &[(String, &StepRecord)]) -> Table {
    let mut table =
        table("mesh|cells|unknowns|relative\nerror %|mean\nerror|mean sq.\nerror|strain\nenergy|worst\nangle");
    for (label, r) in rows {
        table.add_row([
            label.clone(),
            count(r.mesh.cells),
            count(r.free_dofs),
            percent(r.error.relative),
            figures(r.error.normalised_mean, 3),
            figures(r.error.normalised_mean_square, 3),
            figures(r.strain_energy, 6),
            format!("{:.1}", r.quality.worst),
        ]);
    }
    table
}

/// The phases of which the ratios are made.
fn phases(rows: &[(String, &StepRecord)]) -> Table {
    let mut table = table("mesh|refine|assemble|solve|estimate|mark");
    for (label, r) in rows {
        let s = &r.seconds;
        let phases = [s.refine, s.assemble, s.solve, s.estimate, s.mark].map(seconds);
        table.add_row([label.clone()].into_iter().chain(phases));
    }
    table
}

fn equal_steps(global: &Report, adaptive: &Report, ratios: &Ratios) -> Table {
    let mut table =
        table("step|cells|unknowns|assemble\n+ solve|refine +\nassemble + solve|all but\nwriting|strain\nenergy");
    for (ratio, (g, a)) in ratios.equal_step.iter().zip(global.steps.iter().zip(&adaptive.steps)) {
        table.add_row([
            ratio.step.to_string(),
            figures(ratio.cells, 3),
            figures(ratio.unknowns, 3),
            figures((g.seconds.assemble + g.seconds.solve) / (a.seconds.assemble + a.seconds.solve), 3),
            figures(simulation(&g.seconds) / simulation(&a.seconds), 3),
            figures(ratio.seconds, 3),
            figures(ratio.energy, 5),
        ]);
    }
    table
}

/// The time that the 2011 paper's "simulation" is held against.
fn simulation(seconds: &PhaseSeconds) -> f64 {
    seconds.refine + seconds.assemble + seconds.solve
}

fn equal_error(e: &EqualError) -> String {
    let (Some(error), None) = (e.error, &e.reason) else {
        return format!(
            "Global over adaptive at equal error: none, {}",
            e.reason.as_deref().unwrap_or("no common error")
        );
    };
    let [cells, unknowns, seconds, memory] =
        [e.cells, e.unknowns, e.seconds, e.memory].map(|r| r.map_or("-".to_owned(), |r| figures(r, 3)));
    format!(
        "Global over adaptive at equal {} relative error ({} %)\n\
         cells {cells}, unknowns {unknowns}, memory {memory},\n\
         seconds of computing from the start {seconds} (log-log between steps)",
        e.error_source,
        percent(error)
    )
}

fn beside(rows: &[(String, &StepRecord)], published: &Published) -> Table {
    let mut table = table("mesh|cells|cells\npublished|ms|ms\npublished|mean\nerror|mean sq.\nerror|error\npublished");
    for p in &published.steps {
        let ours = rows.iter().find(|(label, _)| *label == p.label).map(|(_, r)| r);
        let cell = |f: &dyn Fn(&StepRecord) -> String| ours.map_or("-".to_owned(), |r| f(r));
        table.add_row([
            p.label.clone(),
            cell(&|r| count(r.mesh.cells)),
            count(p.cells),
            cell(&|r| figures(1e3 * simulation(&r.seconds), 3)),
            p.milliseconds.to_string(),
            cell(&|r| figures(r.error.normalised_mean, 3)),
            cell(&|r| figures(r.error.normalised_mean_square, 3)),
            p.error.to_string(),
        ]);
    }
    table
}

/// For each step published of both runs: how many times longer the global one takes, there and here.
fn factors(rows: &[(String, &StepRecord)], published: &Published) -> Vec<String> {
    let find = |label: &str| published.steps.iter().find(|p| p.label == label);
    let ours = |label: &str| rows.iter().find(|(l, _)| l == label).map(|(_, r)| simulation(&r.seconds));
    let pair = |a: &PublishedStep| {
        let step = a.label.strip_prefix("adaptive ")?;
        let global = format!("global {step}");
        let g = find(&global)?;
        let theirs =
            format!("{:.1} published ({} ms / {} ms)", g.milliseconds / a.milliseconds, g.milliseconds, a.milliseconds);
        let ours = ours(&global).zip(ours(&a.label)).map_or("-".to_owned(), |(g, a)| format!("{:.1}", g / a));
        Some(format!("Time, global over adaptive at step {step}: {ours} here, {theirs}"))
    };
    published.steps.iter().filter_map(pair).collect()
}

/// An empty table whose headers are separated by `|`; the first column is text, the others are numbers.
#[must_use]
pub fn table(headers: &str) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY.row_separator(LineStyle::none()));
    table.set_header(headers.split('|'));
    table.set_content_arrangement(ContentArrangement::Dynamic).set_width(COLUMNS);
    for column in table.column_iter_mut() {
        column.set_cell_alignment(if column.index == 0 { CellAlignment::Left } else { CellAlignment::Right });
        column.set_padding((if column.index == 0 { 0 } else { 1 }, 0));
    }
    table
}

/// The table as text. Where it is too wide its texts are wrapped, but no column is narrower than the words of its head and the
/// numbers in it: they would break into other numbers.
#[must_use]
pub fn text(mut table: Table) -> String {
    let widths: Vec<usize> = (0..table.column_count()).map(|column| widest_word(&table, column)).collect();
    for (column, width) in table.column_iter_mut().zip(widths) {
        let width = u16::try_from(width).unwrap_or(COLUMNS) + column.padding_width();
        column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(width)));
    }
    table.trim_fmt()
}

/// Characters of the longest number in a column, with the comma behind it, and of the longest word of its head.
fn widest_word(table: &Table, column: usize) -> usize {
    let head = table.header().and_then(|row| row.cell_iter().nth(column)).map(Cell::content).unwrap_or_default();
    let head = head.split_whitespace().map(|word| word.chars().count()).max().unwrap_or(0);
    let cells = table.row_iter().filter_map(|row| row.cell_iter().nth(column));
    let number = |word: &&str| {
        let bare = word.trim_matches(['(', ')', ',', '[', ']']).replace(',', "");
        bare.parse::<f64>().is_ok()
    };
    let widest = |cell: &Cell| cell.content().split_whitespace().filter(number).map(str::len).max();
    cells.filter_map(widest).max().unwrap_or(0).max(head)
}

/// An integer with its thousands apart.
#[must_use]
pub fn count(n: usize) -> String {
    let digits = n.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|group| std::str::from_utf8(group).ok()).collect();
    groups.join(",")
}

/// A number with that many significant figures, in the shorter of the plain and the scientific notation.
#[must_use]
pub fn figures(x: f64, digits: usize) -> String {
    if !x.is_finite() {
        return "-".to_owned();
    }
    // Rounding first, so that 9.99 with one figure counts as 10.
    let scientific = format!("{x:.*e}", digits.saturating_sub(1));
    let exponent: i32 = scientific.rsplit_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0);
    match usize::try_from(digits as i32 - 1 - exponent) {
        Ok(decimals) if exponent >= -4 => format!("{x:.decimals$}"),
        Err(_) if exponent < 9 => format!("{x:.0}"),
        _ => scientific,
    }
}

/// A number with at most so many significant figures and no zeros behind them; small and large ones in scientific notation.
#[must_use]
pub fn short(x: f64, digits: usize) -> String {
    let scientific = format!("{x:.*e}", digits.saturating_sub(1));
    // The nearest number of so many figures prints with these figures.
    let x = scientific.parse().unwrap_or(x);
    let plain = x == 0.0 || (1e-4..1e9).contains(&x.abs());
    if plain || !x.is_finite() { x.to_string() } else { format!("{x:e}") }
}

/// A fraction in percent, with three significant figures.
#[must_use]
pub fn percent(x: f64) -> String {
    figures(100.0 * x, 3)
}

fn seconds(s: f64) -> String {
    if s.is_finite() { format!("{s:.3}") } else { "-".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::super::compare::ratios;
    use super::super::report::tests::{report, step};
    use super::*;

    #[test]
    fn short_numbers_keep_their_figures_and_nothing_else() {
        for (x, want) in [
            (0.0, "0"),
            (-2.0, "-2"),
            (0.1 + 0.2, "0.3"),
            (7.85e-9, "7.85e-9"),
            (210e9, "2.1e11"),
            (0.000_001_906_670_000_000_000_1, "1.90667e-6"),
            (123_456_789.0, "123457000"),
        ] {
            assert_eq!(short(x, 6), want);
        }
    }

    #[test]
    fn numbers_are_rounded_to_significant_figures() {
        let cases = [(0.0, "0.00"), (9.999, "10.0"), (0.012345, "0.0123"), (123_456.0, "123456"), (-2.5, "-2.50")];
        for (x, expected) in cases {
            assert_eq!(figures(x, 3), expected);
        }
        assert_eq!(figures(1.0e-7, 3), "1.00e-7");
        assert_eq!(figures(2.346e12, 3), "2.35e12");
        assert_eq!(figures(f64::NAN, 3), "-");
        assert_eq!([count(7), count(1_234), count(1_234_567)], ["7", "1,234", "1,234,567"]);
    }

    /// The run of the paper, with times a tenth of its.
    fn run(cells: [usize; 2], milliseconds: [f64; 2], error: [f64; 2]) -> Report {
        let record = |i: usize| {
            let mut r = step(i);
            r.mesh.cells = cells[i];
            r.error.relative = error[i];
            r.seconds = PhaseSeconds { solve: milliseconds[i] / 1e4, total: milliseconds[i] / 1e4, ..r.seconds };
            r.seconds.assemble = 0.0;
            r
        };
        report(vec![record(0), record(1)])
    }

    fn published() -> Published {
        let steps =
            [("base", 2799, 491.0, 0.08), ("adaptive 1", 4540, 596.0, 0.03), ("global 1", 23480, 7574.0, 0.008)];
        let steps = steps.map(|(label, cells, milliseconds, error)| PublishedStep {
            label: label.to_owned(),
            cells,
            milliseconds,
            error,
        });
        Published { source: "Burkhart, Hamann and Umlauf 2011, Figure 6".to_owned(), steps: steps.into() }
    }

    #[test]
    fn the_comparison_prints_every_mesh_once_and_the_published_factor_beside_ours() {
        let global = run([2799, 23480], [491.0, 7574.0], [0.4, 0.2]);
        let adaptive = run([2799, 4540], [491.0, 596.0], [0.4, 0.3]);
        let text = comparison(&global, &adaptive, &ratios(&global, &adaptive), Some(&published()));
        let line = |start: &str| text.lines().filter(|l| l.starts_with(start)).collect::<Vec<_>>();
        assert_eq!(line("global 1").len(), 3);
        assert_eq!(line("base").len(), 3);
        assert!(line("Time, global")[0].contains("12.7 here, 12.7 published (7574 ms / 596 ms)"), "{text}");
        let beside: Vec<&str> = line("adaptive 1")[2].split_whitespace().collect();
        assert_eq!(beside[2..6], ["4,540", "4,540", "59.6", "596"]);
        assert!(line("Global over adaptive at equal estimated relative error (30.0 %)").len() == 1, "{text}");
    }

    #[test]
    fn published_rows_without_ours_and_ratios_without_a_common_error_are_said() {
        let global = run([2799, 23480], [491.0, 7574.0], [0.2, 0.1]);
        let mut adaptive = run([2799, 4540], [491.0, 596.0], [0.4, 0.3]);
        adaptive.steps.truncate(1);
        let text = comparison(&global, &adaptive, &ratios(&global, &adaptive), Some(&published()));
        assert!(text.contains("at equal error: none, the global run starts with the error"), "{text}");
        assert!(text.contains("at step 1: - here, 12.7 published"), "{text}");
    }

    #[test]
    fn a_run_of_one_step_fits_a_narrow_terminal() {
        let text = steps(&[step(0)]);
        assert!(text.lines().take(6).all(|l| l.chars().count() <= 80), "{text}");
        assert!(text.contains("2,799") && text.contains("6.38233"));
        assert!(step_line(&step(0)).starts_with("step 0: 2,799 cells, 2,800 unknowns, relative error 40.0 %"));
    }
}
