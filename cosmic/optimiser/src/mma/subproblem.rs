//! The convex, separable subproblem of one update, and its minimiser at given multipliers.
//!
//! Let `a_j` and `b_j` be the distances of variable `j` from its upper and lower asymptote, and `s_j` its step. The
//! model of every function is (Svanberg 1987, equations 4-9)
//!
//! `f(s) = f(0) + sum_j rise_j a_j s_j / (a_j - s_j) - fall_j b_j s_j / (b_j + s_j)`,
//!
//! which is the usual `p / (upp - x) + q / (x - low)` with `p = rise a^2` and `q = fall b^2`, written as a function of
//! the step. In this form no large terms cancel, even if the asymptotes are far away.
//!
//! For fixed multipliers, the Lagrangian has the same form: a sum with one term per variable. The minimum of each term
//! over the allowed steps of its variable, which are called its box, has a closed form.

/// This share of the absolute derivative is added to `rise` and to `fall`, so that every model is strictly convex
/// (Svanberg 2007, "MMA and GCMMA", section 3).
const CONVEXITY: f64 = 0.001;

/// The cost `c y + d y^2 / 2` of the elastic variable `y >= 0` of each constraint `f - y <= 0`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Elastic {
    /// `c`, at least 0.
    pub(super) linear: f64,
    /// `d`, above 0.
    pub(super) quadratic: f64,
}

impl Elastic {
    /// The value of `y` that minimises `c y + d y^2 / 2 - multiplier * y`.
    pub(super) fn extension(self, multiplier: f64) -> f64 {
        ((multiplier - self.linear) / self.quadratic).max(0.0)
    }
}

/// How far one variable may move in this update, and how far it is from its asymptotes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Room {
    /// Distance of the variable from its upper asymptote.
    pub(super) to_upp: f64,
    /// Distance of the variable from its lower asymptote.
    pub(super) to_low: f64,
    /// The least step, which is at most 0.
    pub(super) least: f64,
    /// The largest step, which is at least 0.
    pub(super) most: f64,
    /// The upper bound of the variable minus its lower bound, above 0.
    pub(super) range: f64,
}

/// The two terms `a s / (a - s)` and `-b s / (b + s)` of a step. A model multiplies them by its [`ModelWeights`].
fn shares(reach: &Room, step: f64) -> (f64, f64) {
    let Room { to_upp, to_low, .. } = *reach;
    (
        to_upp * step / (to_upp - step),
        -to_low * step / (to_low + step),
    )
}

/// The weights `rise` and `fall` of the model of one function, with an entry per variable.
#[derive(Debug, Clone, Default)]
struct ModelWeights {
    rise: Vec<f64>,
    fall: Vec<f64>,
}

/// The models of all functions. Also the steps that minimise the Lagrangian for the last multipliers.
#[derive(Debug, Clone, Default)]
pub(super) struct Subproblem {
    reach: Vec<Room>,
    objective: ModelWeights,
    constraints: Vec<ModelWeights>,
    /// The values of the constraints at the point.
    pub(super) values: Vec<f64>,
    /// For each constraint, the sum of the absolute values of its terms, at the place within the box where this sum is
    /// largest. The rounding error of the constraint is a few ulps of this sum.
    pub(super) sizes: Vec<f64>,
    /// For each constraint, the largest value of its model within the box.
    pub(super) peaks: Vec<f64>,
    /// The weights of the Lagrangian.
    lagrangian: ModelWeights,
    /// The steps that minimise the Lagrangian for the last multipliers.
    pub(super) steps: Vec<f64>,
    up: Vec<f64>,
    down: Vec<f64>,
    /// For each constraint and variable, the slope of the model divided by the square root of the Lagrangian's
    /// curvature. It is 0 for a variable at the edge of its box.
    scaled: Vec<Vec<f64>>,
}

impl Subproblem {
    /// Begins a new subproblem without functions. `reach` has a [`Room`] for each variable.
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

    /// Sets the model of the objective from its gradient, with an entry per variable. `curvature / range` is added to
    /// the weights of the model.
    pub(super) fn set_objective(&mut self, gradient: impl Iterator<Item = f64>, curvature: f64) {
        self.objective.set(&self.reach, gradient, curvature);
    }

    /// Adds the model of the next constraint from its value and gradient. `curvature / range` is added to the weights
    /// of the model.
    pub(super) fn add_constraint(
        &mut self,
        value: f64,
        gradient: impl Iterator<Item = f64>,
        curvature: f64,
    ) {
        let index = self.values.len();
        if self.constraints.len() == index {
            self.constraints.push(ModelWeights::default());
            self.scaled.push(Vec::new());
        }
        let slopes = &mut self.constraints[index];
        slopes.set(&self.reach, gradient, curvature);
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

    /// Minimises the Lagrangian over the box, and writes the value of each constraint's model at the minimum to
    /// `models`. Returns the Lagrangian at the minimum, relative to the objective at the point.
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

    /// The models of all functions at the last steps: the change of the objective, then the value of each constraint.
    pub(super) fn models(&self) -> Vec<f64> {
        let (up, down): (Vec<f64>, Vec<f64>) = (self.reach.iter().zip(&self.steps))
            .map(|(reach, &step)| shares(reach, step))
            .unzip();
        let constraints = self.values.iter().zip(&self.constraints);
        std::iter::once(self.objective.change(&up, &down))
            .chain(constraints.map(|(value, slopes)| value + slopes.change(&up, &down)))
            .collect()
    }

    /// The increase of a model at the last steps if its curvature increases by 1 (Svanberg 2002, the function `d_k`).
    /// It is at least 0, and 0 only if no variable moves.
    pub(super) fn bend(&self) -> f64 {
        let term = |(reach, step): (&Room, &f64)| {
            let (above, below) = (reach.to_upp - step, reach.to_low + step);
            (reach.to_upp + reach.to_low) / above * step / below * step / reach.range
        };
        self.reach.iter().zip(&self.steps).map(term).sum()
    }

    /// Computes the negative curvature of the dual at the last multipliers, without the part of the elastic variables,
    /// and writes it to `matrix`. The entries are `sum_j s_ij s_kj / curvature_j` over the variables inside their
    /// boxes, where `s` are the slopes of the models. The matrix has only the rows and columns of the constraints
    /// `among`, and is row-major.
    pub(super) fn dual_curvature(&mut self, among: &[usize], matrix: &mut Vec<f64>) {
        for (j, reach) in self.reach.iter().enumerate() {
            // The buffers `up` and `down` are reused for the slope weights.
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
    fn set(&mut self, reach: &[Room], gradient: impl Iterator<Item = f64>, curvature: f64) {
        self.rise.clear();
        self.fall.clear();
        for (slope, reach) in gradient.zip(reach) {
            let both = CONVEXITY * slope.abs() + curvature / reach.range;
            self.rise.push(slope.max(0.0) + both);
            self.fall.push((-slope).max(0.0) + both);
        }
    }

    /// The change of the model from its value at the point, given the two terms of every step.
    fn change(&self, up: &[f64], down: &[f64]) -> f64 {
        dot(&self.rise, up) + dot(&self.fall, down)
    }

    fn term(&self, j: usize, (up, down): (f64, f64)) -> f64 {
        self.rise[j] * up + self.fall[j] * down
    }
}

/// The step within the box that minimises `rise a s / (a - s) - fall b s / (b + s)`.
///
/// The derivative vanishes where `sqrt(rise) a (b + s) = sqrt(fall) b (a - s)`. The solution contains the difference of
/// the two square roots. It is computed from `fall - rise`, so that a variable with `rise = fall` does not move at all.
fn minimiser(reach: &Room, rise: f64, fall: f64) -> f64 {
    let Room { to_upp, to_low, .. } = *reach;
    let (root_rise, root_fall) = (rise.sqrt(), fall.sqrt());
    let scale = (root_rise + root_fall) * (to_upp * root_rise + to_low * root_fall);
    let step = to_upp * to_low * (fall - rise) / scale;
    // Unlike `max` and `min`, these comparisons keep a NaN, which the check of the steps then finds.
    if step < reach.least {
        reach.least
    } else if step > reach.most {
        reach.most
    } else {
        step
    }
}

/// The factors of `rise` and `-fall` in the slope of a model, divided by the square root of the Lagrangian's curvature.
/// They are 0 for a variable at the edge of its box, because it does not respond to the multipliers.
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

/// The scalar product. It is computed as four interleaved sums, which is fast and gives the same bits on every machine.
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
