//! Layout of a figure: title, legend, rows of panels.

use std::fmt::Debug;

use super::legend::{Entry, Legend, entries};
use super::number::wrap;
use super::panel::{Frame, Layout, Sides};
use super::svg::{Anchor, Canvas, Font};
use super::{Figure, Panel, Shape};

/// Font of the title of a picture.
pub(super) const TITLE: Font = Font { bold: true, ..Font::new(18.0, "t", Anchor::Start) };
/// Margin around a picture.
pub(super) const MARGIN: f64 = 16.0;
const GAP: f64 = 30.0;
/// Height of the line of a name, and the most names for which a plot grows.
const NAME_HEIGHT: f64 = 16.0;
const MOST_NAMES: usize = 60;
/// Plots narrower than this are not drawn; the figure gets fewer columns instead.
const NARROWEST: f64 = 130.0;
/// Width of a picture of several columns, and of one that fills a wide screen.
pub(super) const WIDE: f64 = 1200.0;
/// Width of a telephone, without the margins of a page.
const NARROW: f64 = 358.0;

/// An id prefix from the content (FNV-1a), so that different pictures have different prefixes.
pub(super) fn default_id(figure: &impl Debug) -> String {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in format!("{figure:?}").bytes() {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
    format!("chart{:08x}", (hash ^ (hash >> 32)) & 0xffff_ffff)
}

/// Draws the figure.
pub(super) fn compose(figure: &Figure, id: &str) -> Canvas {
    let columns = figure.columns.clamp(1, figure.panels.len().clamp(1, 6));
    let mut grid = Grid::new(&figure.panels, columns);
    while grid.columns > 1 && grid.plot_widths().any(|w| w < NARROWEST) {
        grid = Grid::new(&figure.panels, grid.columns - 1);
    }
    draw(figure, id, grid, shared_legend(&figure.panels).as_deref())
}

/// Draws the figure in one column, as wide as a wide screen.
pub(super) fn compose_wide(figure: &Figure, id: &str) -> Canvas {
    let grid = Grid::of(&figure.panels, 1, WIDE, 16.0, 360.0);
    draw(figure, id, grid, shared_legend(&figure.panels).as_deref())
}

/// Draws the figure in one column, as wide as a telephone; each panel has its own legend.
pub(super) fn compose_narrow(figure: &Figure, id: &str) -> Canvas {
    draw(figure, id, Grid::narrow(&figure.panels), None)
}

fn draw(figure: &Figure, id: &str, grid: Grid, shared: Option<&[Entry]>) -> Canvas {
    let margin = grid.margin;
    let mut canvas = Canvas::new(id, grid.width);
    let inner = grid.width - 2.0 * margin;
    let marked = figure.panels.iter().any(several_lines);

    let mut y = margin;
    let title = canvas.lines(&TITLE, margin, y, &wrap(&figure.title, TITLE.size, true, inner));
    y += title + if title > 0.0 { 8.0 } else { 0.0 };
    if let Some(entries) = shared {
        let legend = Legend::flow(entries, inner);
        legend.draw(&mut canvas, margin, y, marked);
        y += legend.height + if legend.height > 0.0 { 12.0 } else { 0.0 };
    }
    let (columns, frames, height) = (grid.columns, grid.frames(), grid.plot_height);
    let alone = [grid.alone()];
    let mut sides = grid.sides.into_iter();
    for row in figure.panels.chunks(columns) {
        let frames = if row.len() == 1 { alone.as_slice() } else { &frames };
        let layouts: Vec<Layout<'_>> = row
            .iter()
            .zip(frames)
            .zip(sides.by_ref().take(row.len()))
            .map(|((panel, frame), sides)| {
                let own = if shared.is_some() { Vec::new() } else { entries(panel) };
                Layout::new(panel, *frame, sides, &own)
            })
            .collect();
        let header = layouts.iter().map(Layout::header).fold(0.0, f64::max);
        let footer = layouts.iter().map(Layout::footer).fold(0.0, f64::max);
        for layout in &layouts {
            layout.draw(&mut canvas, y, header, height, marked);
        }
        y += header + height + footer + GAP - 8.0;
    }
    canvas.height = if figure.panels.is_empty() { y + margin } else { y - GAP + 8.0 + margin };
    canvas
}

/// The common legend, if all panels with a legend have the same one.
fn shared_legend(panels: &[Panel]) -> Option<Vec<Entry>> {
    let mut all = panels.iter().map(entries).filter(|e| !e.is_empty());
    let first = all.next()?;
    all.all(|e| e == first).then_some(first)
}

/// Whether a panel has lines of different colours, which then need markers.
fn several_lines(panel: &Panel) -> bool {
    let line = |s: &&super::Series| matches!(s.shape, Shape::Line | Shape::Dashed | Shape::LineWithDots);
    let mut colours = panel.series.iter().filter(line).map(|s| s.colour);
    colours.next().is_some_and(|first| colours.any(|c| c != first))
}

/// The columns of a figure.
#[derive(Debug)]
struct Grid {
    columns: usize,
    width: f64,
    margin: f64,
    plot_height: f64,
    sides: Vec<Sides>,
    /// Room for the tick labels on both sides of each column.
    rooms: Vec<(f64, f64)>,
}

impl Grid {
    fn new(panels: &[Panel], columns: usize) -> Self {
        let plot_height = match columns {
            1 => 360.0,
            2 => 260.0,
            _ => 210.0,
        };
        Self::of(panels, columns, if columns == 1 { 880.0 } else { WIDE }, 16.0, plot_height)
    }

    /// One column, wider than a telephone only where the labels leave no room for a plot.
    fn narrow(panels: &[Panel]) -> Self {
        let mut grid = Self::of(panels, 1, NARROW, 6.0, 240.0);
        let missing = grid.plot_widths().map(|w| NARROWEST - w).fold(0.0, f64::max);
        grid.width += missing;
        grid
    }

    fn of(panels: &[Panel], columns: usize, width: f64, margin: f64, plot_height: f64) -> Self {
        // Every name beside a plot has a line of its own.
        let names = panels.iter().map(|p| p.y.names.len()).max().unwrap_or(0).min(MOST_NAMES);
        let plot_height = plot_height.max(NAME_HEIGHT * names as f64);
        let sides: Vec<Sides> = panels.iter().map(|p| Sides::new(p, plot_height)).collect();
        let mut rooms = vec![(0.0_f64, 0.0_f64); columns];
        for row in sides.chunks(columns) {
            for (room, side) in rooms.iter_mut().zip(row) {
                *room = (room.0.max(side.room.0), room.1.max(side.room.1));
            }
        }
        Self { columns, width, margin, plot_height, sides, rooms }
    }

    fn panel_width(&self) -> f64 {
        (self.width - 2.0 * self.margin - (self.columns - 1) as f64 * GAP) / self.columns as f64
    }

    fn plot_widths(&self) -> impl Iterator<Item = f64> {
        self.rooms.iter().map(|(left, right)| self.panel_width() - left - right)
    }

    /// The frame of a panel that has a row for itself.
    fn alone(&self) -> Frame {
        let (left, right) = self.rooms.first().copied().unwrap_or_default();
        let width = self.width - 2.0 * self.margin;
        Frame { x: self.margin, width, plot_x: self.margin + left, plot_width: width - left - right }
    }

    fn frames(&self) -> Vec<Frame> {
        let width = self.panel_width();
        let frame = |(i, (left, right)): (usize, &(f64, f64))| {
            let x = self.margin + i as f64 * (width + GAP);
            Frame { x, width, plot_x: x + left, plot_width: width - left - right }
        };
        self.rooms.iter().enumerate().map(frame).collect()
    }
}
