//! The learned clock: its frequency is a design variable.
//!
//! The angular frequency is `omega exp(tempo)`, with the number `tempo` of the controller. An update of `tempo` is thus
//! a relative change of the frequency, in any units of time.

use autodiff::Real;
use autodiff_programs::Kernel;

use super::block::Controller;
use super::sensing::clock;
use crate::kernel;
use crate::scene::{ClockKind, ControllerSettings};

/// The name of the block of a learned clock. It has one number, which starts at zero, and comes after the blocks of the
/// policy.
pub const TEMPO: &str = "tempo";

/// The angular frequency of a robot's clock, rad/s.
///
/// # Panics
/// If the clock is learned and the controller has no block [`TEMPO`].
pub fn frequency(settings: &ControllerSettings, controller: &Controller<f64>) -> f64 {
    match settings.clock {
        ClockKind::Fixed => settings.omega,
        ClockKind::Learned => settings.omega * controller.block(TEMPO)[0].exp(),
    }
}

/// The numbers of the clock that a step gets at the time `time`, in pairs. A fixed clock has one pair, the
/// [clock](clock()). A learned clock has three: the clock at the frequency `omega`, its derivative by the phase, and
/// a pair of equal phases. From these, the step computes the clock by [`Turn`].
pub(crate) fn ticks(settings: &ControllerSettings, time: f64) -> Vec<[f64; 2]> {
    let phase = settings.omega * time;
    let [sin, cos] = clock(phase);
    match settings.clock {
        ClockKind::Fixed => vec![[sin, cos]],
        ClockKind::Learned => vec![[sin, cos], [cos, -sin], [phase, phase]],
    }
}

/// The uniform input of [`Turn`]: the relative change of the frequency, `exp(tempo) - 1`; `None` if the clock is fixed.
pub(crate) fn ahead<R: Real>(
    settings: &ControllerSettings,
    controller: &Controller<R>,
) -> Option<R> {
    let is_learned = settings.clock == ClockKind::Learned;
    is_learned.then(|| controller.block(TEMPO)[0].exp() - R::one())
}

/// The kernel of a learned clock. It turns the clock of frequency `omega` by the phase that the change of the frequency
/// adds. With a `tempo` of 0, the result has the bits of a fixed clock. In single precision, the large phase of the
/// clock of frequency `omega` keeps its digits, because its sine and cosine are computed in double precision.
pub(crate) struct Turn;

#[kernel]
impl Kernel<3, 1> for Turn {
    const UNIFORMS: usize = 1;

    fn eval<R: Real>(&self, [clock, slope, phase]: [R; 3], ahead: &[R]) -> [R; 1] {
        let turn = phase * ahead[0];
        [clock * turn.cos() + slope * turn.sin()]
    }
}
