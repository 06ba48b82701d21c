//! Design gradients averaged over the passes behind.

use super::slopes::Slope;

impl Slope {
    /// Moves the running mean of earlier gradients by a share `1 - memory` of the way to this one,
    /// and becomes that mean. The first gradient is its own mean, and so is every one without a
    /// memory; one that is not finite leaves the mean alone and stays what it is.
    pub(super) fn averaged(&mut self, mean: &mut Vec<f64>, memory: f64) {
        if memory == 0.0 || !self.gradient.iter().all(|g| g.is_finite()) {
            return;
        }
        if mean.is_empty() {
            mean.clone_from(&self.gradient);
        }
        for (mean, g) in mean.iter_mut().zip(&mut self.gradient) {
            *mean = memory * *mean + (1.0 - memory) * *g;
            *g = *mean;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Slope;

    fn slope(gradient: [f64; 2]) -> Slope {
        Slope {
            loss: 0.0,
            gradient: gradient.to_vec(),
            displacement: 0.0,
        }
    }

    #[test]
    fn a_mean_remembers_by_its_share() {
        let mut mean = Vec::new();
        let mut averaged = |gradient| {
            let mut slope = slope(gradient);
            slope.averaged(&mut mean, 0.75);
            slope.gradient
        };
        assert_eq!(averaged([4.0, -8.0]), [4.0, -8.0]);
        assert_eq!(averaged([0.0, 8.0]), [3.0, -4.0]);
        // One that is not finite is to be seen and skipped, and forgotten.
        assert_eq!(averaged([f64::INFINITY, 1.0]), [f64::INFINITY, 1.0]);
        assert_eq!(averaged([3.0, -4.0]), [3.0, -4.0]);
    }

    #[test]
    fn without_memory_every_gradient_is_its_own() {
        let (mut mean, mut slope) = (Vec::new(), slope([1.0, 2.0]));
        slope.averaged(&mut mean, 0.0);
        assert_eq!(slope.gradient, [1.0, 2.0]);
        assert!(mean.is_empty());
    }
}
