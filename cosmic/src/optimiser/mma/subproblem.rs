//! The convex, separable subproblem of one update, and its minimiser at given multipliers.
//!
//! With `a` and `b` the distances of a variable from its upper and lower asymptote and `s` its
//! step, every function is modelled as (Svanberg 1987, equations 4-9)
//!
//! `f(s) = f(0) + sum_j rise_j a s / (a - s) - fall_j b s / (b + s)`,
//!
//! which is the usual `p / (upp - x) + q / (x - low)` with `p = rise a^2`, `q = fall b^2`, written
//! in the step. So no large terms cancel, however far away an asymptote is.
//!
//! At fixed multipliers the Lagrangian falls apart into one such function per variable, whose
//! minimum over the variable's box has a closed form.

/// Share of `|df|` that both `rise` and `fall` get, so that every model is strictly convex
/// (Svanberg 2007, "MMA and GCMMA", section 3).
const CONVEXITY: f64 = 0.001;

/// The elastic variable `y >= 0` of each constraint `f - y <= 0`; it costs `c y + d y^2 / 2`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Elastic {
    /// `c`, at least 0.
    pub(super) linear: f64,
    /// `d`, above 0.
    pub(super) quadratic: f64,
}

impl Elastic {
    /// The `y` of least cost at the price `multiplier` per unit.
    pub(super) fn extension(self, multiplier: f64) -> f64 {
        ((multiplier - self.linear) / self.quadratic).max(0.0)
    }
}

/// Where one variable may go in this update.
#[derive(Debug, Clone, Copy)]
pub(super) struct Room {
    /// Distance to the upper asymptote.
    pub(super) to_upp: f64,
    /// Distance to the lower asymptote.
    pub(super) to_low: f64,
    /// Least step, at most 0.
    pub(super) least: f64,
    /// Largest step, at least 0.
    pub(super) most: f64,
    /// Curvature that every model gets besides: `raa0 / (xmax - xmin)`.
    pub(super) floor: f64,
}

/// The two shares of a step `s`, towards each asymptote, that [`ModelWeights`] weigh.
fn shares(reach: &Room, step: f64) -> (f64, f64) {
    let Room { to_upp, to_low, .. } = *reach;
    (
        to_upp * step / (to_upp - step),
        -to_low * step / (to_low + step),
    )
}

/// The weights of one function's model, an entry per variable.
#[derive(Debug, Clone, Default)]
struct ModelWeights {
    rise: Vec<f64>,
    fall: Vec<f64>,
}

/// The models of all functions, and the minimiser for the multipliers evaluated last.
#[derive(Debug, Clone, Default)]
pub(super) struct Subproblem {
    reach: Vec<Room>,
    objective: ModelWeights,
    constraints: Vec<ModelWeights>,
    /// Constraint values at the point.
    pub(super) values: Vec<f64>,
    /// The magnitude of the terms that make up each constraint, the largest within the box: its
    /// rounding error is a few ulps of this.
    pub(super) sizes: Vec<f64>,
    /// The largest value that the model of each constraint takes within the box.
    pub(super) peaks: Vec<f64>,
    /// The Lagrangian's weights.
    lagrangian: ModelWeights,
    /// The steps that minimise the Lagrangian for the multipliers evaluated last, and their shares.
    pub(super) steps: Vec<f64>,
    up: Vec<f64>,
    down: Vec<f64>,
    /// Each constraint's slope over the root of the Lagrangian's curvature; 0 at the box.
    scaled: Vec<Vec<f64>>,
}

impl Subproblem {
    /// Starts anew with these variables and no function.
    pub(super) fn reset(&mut self, reach: impl Iterator<Item = Room>) {
        self.reach.clear();
        self.reach.extend(reach);
        self.values.clear();
        self.sizes.clear();
        self.peaks.clear();
        for buffer in [&mut self.steps, &mut self.up, &mut self.down] {
            buffer.resize(self.reach.len(), 0.0);
        }
    }

    /// The objective's model from its gradient, one entry per variable.
    pub(super) fn set_objective(&mut self, gradient: impl Iterator<Item = f64>) {
        self.objective.set(&self.reach, gradient);
    }

    /// The next constraint's model from its value and gradient.
    pub(super) fn add_constraint(&mut self, value: f64, gradient: impl Iterator<Item = f64>) {
        let index = self.values.len();
        if self.constraints.len() == index {
            self.constraints.push(ModelWeights::default());
            self.scaled.push(Vec::new());
        }
        let slopes = &mut self.constraints[index];
        slopes.set(&self.reach, gradient);
        let (mut size, mut peak) = (value.abs(), value);
        for (j, reach) in self.reach.iter().enumerate() {
            let low = slopes.term(j, shares(reach, reach.least));
            let high = slopes.term(j, shares(reach, reach.most));
            size += low.abs().max(high.abs());
            peak += low.max(high);
        }
        self.values.push(value);
        self.sizes.push(size);
        self.peaks.push(peak);
    }

    /// Minimises the Lagrangian over the box, writes each constraint's model there, and returns the
    /// Lagrangian's change from the point, constraint values included.
    pub(super) fn minimise(&mut self, multipliers: &[f64], models: &mut [f64]) -> f64 {
        self.lagrangian.rise.clone_from(&self.objective.rise);
        self.lagrangian.fall.clone_from(&self.objective.fall);
        for (slopes, &multiplier) in self.constraints.iter().zip(multipliers) {
            if multiplier != 0.0 {
                add_scaled(&mut self.lagrangian.rise, multiplier, &slopes.rise);
                add_scaled(&mut self.lagrangian.fall, multiplier, &slopes.fall);
            }
        }
        for (j, reach) in self.reach.iter().enumerate() {
            let step = minimiser(reach, self.lagrangian.rise[j], self.lagrangian.fall[j]);
            self.steps[j] = step;
            (self.up[j], self.down[j]) = shares(reach, step);
        }
        for (i, model) in models.iter_mut().enumerate() {
            let slopes = &self.constraints[i];
            *model = self.values[i] + slopes.change(&self.up, &self.down);
        }
        self.lagrangian.change(&self.up, &self.down) + dot(multipliers, &self.values)
    }

    /// The negative curvature of the dual, without the elastic variables' part, for the
    /// multipliers evaluated last: `sum_j s_ij s_kj / curvature_j` over the variables inside
    /// their boxes, with `s` the slopes of the models. Rows and columns of `among` only;
    /// row-major.
    pub(super) fn dual_curvature(&mut self, among: &[usize], matrix: &mut Vec<f64>) {
        for (j, reach) in self.reach.iter().enumerate() {
            // The shares' buffers take the slopes' weights, over the root of the curvature.
            let weights = (self.lagrangian.rise[j], self.lagrangian.fall[j]);
            (self.up[j], self.down[j]) = slope_weights(reach, self.steps[j], weights);
        }
        for &i in among {
            let ModelWeights { rise, fall } = &self.constraints[i];
            let scaled = &mut self.scaled[i];
            scaled.clear();
            scaled.extend((0..rise.len()).map(|j| rise[j] * self.up[j] - fall[j] * self.down[j]));
        }
        matrix.clear();
        for &i in among {
            for &k in among {
                matrix.push(dot(&self.scaled[i], &self.scaled[k]));
            }
        }
    }
}

impl ModelWeights {
    fn set(&mut self, reach: &[Room], gradient: impl Iterator<Item = f64>) {
        self.rise.clear();
        self.fall.clear();
        for (slope, reach) in gradient.zip(reach) {
            let both = CONVEXITY * slope.abs() + reach.floor;
            self.rise.push(slope.max(0.0) + both);
            self.fall.push((-slope).max(0.0) + both);
        }
    }

    /// The model's change from the point for these shares of the steps.
    fn change(&self, up: &[f64], down: &[f64]) -> f64 {
        dot(&self.rise, up) + dot(&self.fall, down)
    }

    fn term(&self, j: usize, (up, down): (f64, f64)) -> f64 {
        self.rise[j] * up + self.fall[j] * down
    }
}

/// The step within the box that minimises `rise a s / (a - s) - fall b s / (b + s)`.
///
/// The derivative vanishes where `sqrt(rise) a (b + s) = sqrt(fall) b (a - s)`; solved for `s` with
/// the difference of the roots as a quotient, so that a balanced variable stays exactly.
fn minimiser(reach: &Room, rise: f64, fall: f64) -> f64 {
    let Room { to_upp, to_low, .. } = *reach;
    let (root_rise, root_fall) = (rise.sqrt(), fall.sqrt());
    let scale = (root_rise + root_fall) * (to_upp * root_rise + to_low * root_fall);
    let step = to_upp * to_low * (fall - rise) / scale;
    // Unlike `max` and `min`, this lets NaN through to whoever checks the steps.
    if step < reach.least {
        reach.least
    } else if step > reach.most {
        reach.most
    } else {
        step
    }
}

/// What `rise` and `-fall` are multiplied with in a model's slope by the step, divided by the root
/// of the Lagrangian's curvature there; 0 for a variable at its box, which does not respond.
fn slope_weights(reach: &Room, step: f64, (rise, fall): (f64, f64)) -> (f64, f64) {
    if step <= reach.least || reach.most <= step {
        return (0.0, 0.0);
    }
    let (above, below) = (reach.to_upp - step, reach.to_low + step);
    let (up, down) = (reach.to_upp / above, reach.to_low / below);
    let (up, down) = (up * up, down * down);
    let root = (2.0 * (rise * up / above + fall * down / below)).sqrt();
    (up / root, down / root)
}

fn add_scaled(sum: &mut [f64], factor: f64, terms: &[f64]) {
    for (sum, term) in sum.iter_mut().zip(terms) {
        *sum += factor * term;
    }
}

/// The scalar product in four interleaved sums: fast, and the same bits on every machine.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a_fours, b_fours) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = (a_fours.remainder().iter().zip(b_fours.remainder()))
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in a_fours.zip(b_fours) {
        for lane in 0..4 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
