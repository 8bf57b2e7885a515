//! While nothing moves: more and more lens points, until the picture is the reference.
//!
//! The first frames turn the lens points of every pixel and are averaged: what is left is
//! the error of the layers. Then true views over the lens, those of `accumulation`, are
//! summed beside. The error of their mean after n is about `PRIOR / n` times that of the
//! layers, and the weights that make the least squares error of both are as the inverse
//! squares.

use super::{AccumulationRun, Adaptive};
use crate::gpu::{Frame, Shader, Texture};
use crate::lens::Lens;
use crate::methods::accumulation::RunningMean;
use crate::methods::{Converging, MethodError};
use crate::view::View;
use crate::{shader, uniform};

const SHADER: Shader = shader!("methods/adaptive_progressive");

/// Frames whose lens points are turned before true views begin.
pub const TURNED_FRAMES: u32 = 8;

/// Number of true views whose mean is as good as the layers': 64 views leave about 40 dB
/// against thousands, as four-layer rays do.
const PRIOR: f32 = 64.0;

uniform! {
    struct Blend {
        share: f32,
    }
}

/// A picture that converges, one frame at a time, as long as view and lens stay.
pub struct AdaptiveRun {
    method: Adaptive,
    turned: RunningMean,
    views: AccumulationRun,
}

impl AdaptiveRun {
    /// A run with no frames yet.
    pub fn new(method: Adaptive) -> Self {
        Self { method, turned: RunningMean::default(), views: AccumulationRun::new(false) }
    }

    fn advance_once(&mut self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens) -> Result<(), MethodError> {
        // An image has no other views: turning lens points is all there is.
        if self.turned.count() >= TURNED_FRAMES && view.is_scene() {
            return self.views.advance(frame, view, lens, 1);
        }
        let image = self.method.turned(frame, view, lens, self.turned.count())?;
        self.turned.add(frame, &image);
        Ok(())
    }
}

impl Converging for AdaptiveRun {
    fn count(&self) -> u32 {
        self.turned.count() + self.views.count()
    }

    fn advance(&mut self, frame: &mut Frame<'_>, view: &mut View, lens: &Lens, n: u32) -> Result<(), MethodError> {
        (0..n).try_for_each(|_| self.advance_once(frame, view, lens))
    }

    fn mean(&self, frame: &mut Frame<'_>) -> Texture {
        let turned = self.turned.mean(frame).expect("a mean needs at least one frame");
        if self.views.count() == 0 {
            return turned;
        }
        let views = self.views.mean(frame);
        let blended = frame.texture("converging", views.size(), views.format());
        let relative = self.views.count() as f32 / PRIOR;
        frame
            .pass(&SHADER, "blend_means")
            .uniform("blend", &Blend { share: relative * relative / (1.0 + relative * relative) })
            .texture("turned", &turned)
            .texture("views", &views)
            .texture("blended", &blended)
            .dispatch(views.size());
        blended
    }
}
