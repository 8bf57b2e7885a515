//! 8x8 tiles by class, so that a pass works where a picture needs it.
//!
//! A method lists tiles by a pass of its own (`list_tile` of `shaders/lib/tile_lists.wgsl`)
//! or by a [`FocusMap`], then dispatches one workgroup for each tile of a class, as the
//! GPU's [`Schedule`] has it: by lists that the GPU makes and reads, or by a branch in each
//! workgroup. Nothing comes back to the CPU.

use super::{Meaning, Quantity, Scale};
use crate::gpu::{Buffer, Frame, Gpu, Pass, Schedule, Shader, Texture};
use crate::lens::Lens;
use crate::view::View;
use crate::{shader, uniform};
use glam::UVec2;

const SHADER: Shader = shader!("methods/tile_lists");

/// Side of a tile, px: `TILE` in the shaders.
pub const TILE_PX: u32 = 8;

/// Classes that can be told apart: `CLASSES` in the shaders.
const CLASSES: u64 = 4;

/// Bytes of a class's workgroups x, y, z and list length.
const DISPATCH_BYTES: u64 = 16;

/// Class of tiles whose pixels are those of the pinhole image.
pub const IN_FOCUS: u32 = 0;

/// Class of tiles that are blurred or that blur reaches, in the lists of a [`FocusMap`].
pub const DEFOCUSED: u32 = 1;

/// Name under which [`TileLists::expose`] shows what was skipped where.
pub const SKIPPED: &str = "tile class: what was skipped";

/// What the texture called [`SKIPPED`] means, where `classes` are the method's own.
pub fn meaning(classes: &'static [(f32, &'static str)]) -> Meaning {
    Meaning::numbers([Quantity::new("tile class", "", Scale::Classes(classes))])
}

uniform! {
    struct Listed {
        tiles: [u32; 2],
        class_of: u32,
        by_branches: u32,
    }
}

uniform! {
    struct Focus {
        tiles: [u32; 2],
        first_tile: u32,
        overscan: u32,
        reach_per_coc: f32,
        in_focus_coc_px: f32,
        reach: u32,
        more_coc_px: f32,
    }
}

/// The tiles of an image by class.
pub struct TileLists {
    tiles: UVec2,
    schedule: Schedule,
    /// Tiles (x | y << 16), each class's list as long as there are tiles; by branches the
    /// class of each tile.
    pub lists: Buffer,
    /// By class: workgroups in x, y, z, and the list's length.
    pub dispatches: Buffer,
}

impl TileLists {
    /// Empty lists of the tiles of an image of `size` texels.
    pub fn new(gpu: &Gpu, size: UVec2) -> Self {
        let tiles = size.map(|side| side.div_ceil(TILE_PX));
        let schedule = gpu.schedule();
        let lists = if schedule == Schedule::Branches { 1 } else { CLASSES };
        let bytes = 4 * lists * u64::from(tiles.x) * u64::from(tiles.y);
        Self {
            tiles,
            schedule,
            lists: gpu.scratch("tile lists", bytes),
            // By branches it is bound and not looked at.
            dispatches: match schedule {
                Schedule::TileLists => gpu.indirect_buffer("tile dispatches", CLASSES * DISPATCH_BYTES),
                Schedule::Branches => gpu.scratch("tile dispatches", CLASSES * DISPATCH_BYTES),
            },
        }
    }

    /// Tiles along x and y.
    pub fn tiles(&self) -> UVec2 {
        self.tiles
    }

    /// Binds the lists to a pass that fills them.
    pub fn filled_by<'f, 'g>(&self, pass: Pass<'f, 'g>) -> Pass<'f, 'g> {
        pass.uniform("listed", &self.listed(0))
            .buffer("new_lists", &self.lists)
            .buffer("new_dispatches", &self.dispatches)
    }

    /// Makes grids of workgroups from lists that are filled.
    pub fn plan(&self, frame: &mut Frame<'_>) {
        if self.schedule == Schedule::Branches {
            return;
        }
        frame.pass(&SHADER, "plan_dispatches").buffer("new_dispatches", &self.dispatches).dispatch_groups(1, 1, 1);
    }

    /// Runs `pass` with one workgroup for each tile of `class`.
    pub fn dispatch(&self, pass: Pass<'_, '_>, class: u32) {
        let pass = pass
            .uniform("listed", &self.listed(class))
            .buffer("lists", &self.lists)
            .buffer("dispatches", &self.dispatches);
        match self.schedule {
            Schedule::TileLists => pass.dispatch_indirect(&self.dispatches, DISPATCH_BYTES * u64::from(class)),
            Schedule::Branches => pass.dispatch_groups(self.tiles.x, self.tiles.y, 1),
        }
    }

    /// Exposes the class of each tile as its number, where intermediate textures are asked for.
    pub fn expose(&self, frame: &mut Frame<'_>) {
        if !frame.keeps_intermediates() {
            return;
        }
        let classes = frame.texture(SKIPPED, self.tiles, wgpu::TextureFormat::R32Float);
        for class in 0..CLASSES as u32 {
            let pass = frame.pass(&SHADER, "show_class").texture("classes", &classes);
            self.dispatch(pass, class);
        }
        frame.expose(SKIPPED, &classes);
    }

    fn listed(&self, class_of: u32) -> Listed {
        let by_branches = (self.schedule == Schedule::Branches).into();
        Listed { tiles: self.tiles.to_array(), class_of, by_branches }
    }

    /// Copies the image, whose margin is `overscan` px, to `result` in the tiles of class
    /// [`IN_FOCUS`].
    pub fn copy_in_focus(&self, frame: &mut Frame<'_>, color: &Texture, overscan: u32, result: &Texture) {
        let focus = Focus { overscan, ..bytemuck::Zeroable::zeroed() };
        let pass = frame
            .pass(&SHADER, "copy_tiles")
            .uniform("focus", &focus)
            .texture("color", color)
            .texture("result", result);
        self.dispatch(pass, IN_FOCUS);
    }
}

/// Where in a view anything is out of focus, or is reached by something that is.
pub struct FocusMap {
    focus: Focus,
    /// Of each tile of the outer frame: how far what reaches it blurs, px; 0 where nothing does.
    reach_px: Buffer,
}

/// How far blur reaches.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// CoC diameter, px, up to which a pixel is in focus and reaches nothing.
    pub in_focus_coc_px: f64,
    /// How far a pixel reaches, over its CoC diameter.
    pub per_coc: f64,
    /// By how much the diameter is greater than that of the CoC, px: an astigmatic eye's ellipse.
    pub more_coc_px: f64,
}

impl FocusMap {
    /// The map of `view` through `lens`.
    pub fn new(frame: &mut Frame<'_>, view: &mut View, lens: &Lens, blur: Reach) -> Self {
        let first_tile = view.overscan_px().div_ceil(TILE_PX);
        let outer = view.size().map(|side| side.div_ceil(TILE_PX)) + 2 * first_tile;
        let [near_px, far_px] = view.coc_bounds_px(frame, lens);
        let reach_px = (near_px.abs().max(far_px.abs()) + blur.more_coc_px) * blur.per_coc + 1.0;
        let focus = Focus {
            tiles: outer.to_array(),
            first_tile,
            overscan: view.overscan_px(),
            reach_per_coc: blur.per_coc as f32,
            in_focus_coc_px: blur.in_focus_coc_px as f32,
            // No tile is farther away than the frame is wide.
            reach: ((reach_px / f64::from(TILE_PX)).ceil() as u32 + 1).min(outer.max_element()),
            more_coc_px: blur.more_coc_px as f32,
        };
        let bytes = 4 * u64::from(outer.x) * u64::from(outer.y);
        let [marked, rows, all] =
            ["marked reach", "reach along rows", "reach"].map(|label| frame.gpu().scratch(label, bytes));
        let depth = view.pinhole(frame).depth;
        frame
            .pass(&SHADER, "mark_reach")
            .uniform("focus", &focus)
            .uniform("lens", &view.lens_uniform(lens))
            .texture("depth", &depth)
            .buffer("new_reach_px", &marked)
            .dispatch_groups(outer.x.div_ceil(TILE_PX), outer.y, 1);
        for (entry, from, to) in [("spread_rows", &marked, &rows), ("spread_columns", &rows, &all)] {
            frame
                .pass(&SHADER, entry)
                .uniform("focus", &focus)
                .buffer("reach_px", from)
                .buffer("new_reach_px", to)
                .dispatch(outer);
        }
        Self { focus, reach_px: all }
    }

    /// The tiles of the inner frame, [`IN_FOCUS`] or [`DEFOCUSED`].
    pub fn tiles(&self, frame: &mut Frame<'_>, view: &View) -> TileLists {
        let lists = TileLists::new(frame.gpu(), view.size());
        let pass = frame.pass(&SHADER, "list_by_focus");
        self.list(lists.filled_by(pass), &lists);
        lists.plan(frame);
        lists
    }

    fn list(&self, pass: Pass<'_, '_>, lists: &TileLists) {
        pass.uniform("focus", &self.focus).buffer("reach_px", &self.reach_px).dispatch(lists.tiles);
    }
}
