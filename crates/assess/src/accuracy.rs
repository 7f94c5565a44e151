//! Error against time: what independent replicas at growing budgets say of several methods, with intervals.
//!
//! Every interval comes from the bootstrap (Efron 1979) over replicas: each point of a curve is drawn again from its own
//! replicas, with replacement, and everything that follows from the points is computed anew. Means of n replicas drawn again have
//! (n - 1) / n of the variance that means of new replicas would have, so their distance from the mean is stretched by the root of
//! its inverse (Davison and Hinkley 1997, section 2.3); with four replicas that is a seventh.
//!
//! What all replicas of a budget have in common, like the speed of the machine while they ran, they do not tell. A slope is fitted
//! through all budgets, and the scatter of these about the line does: of the two errors the larger is taken (Birge 1932).

use rand_core::Rng;
use rand_pcg::Pcg64;

/// One replica at one budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Seconds of processor time that it took, start-up included.
    pub seconds: f64,
    /// Its error. After the error of a reference is taken off it may be negative.
    pub error: f64,
}

/// One method: its replicas by budget, the smallest budget first.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name of the method.
    pub name: String,
    /// Replicas of each budget; at least one each.
    pub points: Vec<Vec<Sample>>,
}

/// A number with its interval of 95 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// From all replicas as they are.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Standard error.
    pub error: f64,
}

impl Interval {
    /// Whether two intervals have nothing in common.
    pub fn is_apart_from(&self, other: &Self) -> bool {
        self.high < other.low || other.high < self.low
    }
}

/// A point of a curve: mean time, mean error.
type Mean = (f64, f64);

/// Times that replicas are drawn again.
const DRAWS: usize = 1000;

/// A share of all draws for which what is asked for must exist, if it is to have an interval.
const EXISTS: f64 = 0.9;

/// One of `n` indices.
fn index(rng: &mut Pcg64, n: usize) -> usize {
    ((u128::from(rng.next_u64()) * n as u128) >> 64) as usize
}

fn mean_of(samples: impl ExactSizeIterator<Item = Sample>) -> Mean {
    let n = samples.len() as f64;
    let (seconds, error) = samples.fold((0.0, 0.0), |(s, e), sample| (s + sample.seconds, e + sample.error));
    (seconds / n, error / n)
}

impl Curve {
    /// The means of all points.
    pub fn means(&self) -> Vec<Mean> {
        self.points.iter().map(|point| mean_of(point.iter().copied())).collect()
    }

    /// The means of points drawn again, as far from the points' own as those of new replicas would be.
    fn drawn(&self, rng: &mut Pcg64) -> Vec<Mean> {
        let draw = |point: &Vec<Sample>| {
            let n = point.len();
            let mean = mean_of(point.iter().copied());
            let drawn = mean_of((0..n).map(|_| point[index(rng, n)]));
            let stretch = (n as f64 / (n.max(2) - 1) as f64).sqrt();
            (mean.0 + (drawn.0 - mean.0) * stretch, mean.1 + (drawn.1 - mean.1) * stretch)
        };
        self.points.iter().map(draw).collect()
    }

    /// Mean error of each point.
    pub fn errors(&self) -> Vec<Interval> {
        (0..self.points.len()).filter_map(|i| bootstrap([self], |[means]| Some(means[i].1))).collect()
    }

    /// The exponent of error as a power of time, by least squares of logarithms; -1 for an unbiased method. Its error is that
    /// which the replicas tell or that which the scatter of the points about the line tells, whichever is the larger. `None` for
    /// fewer than three points with a positive error.
    pub fn slope(&self) -> Option<Interval> {
        let within = bootstrap([self], |[means]| Some(line(means)?.slope))?;
        let between = line(&self.means())?.error;
        let stretch = (between / within.error).max(1.0);
        if !stretch.is_finite() {
            return Some(within);
        }
        let stretched = |end: f64| within.value + (end - within.value) * stretch;
        Some(Interval {
            value: within.value,
            low: stretched(within.low),
            high: stretched(within.high),
            error: within.error * stretch,
        })
    }

    /// Seconds after which the error is no longer above a level, straight between the points on logarithmic axes; `None` if it is at the
    /// last point, or at none. A smaller error is never reached sooner than a larger one, however rough the curve.
    pub fn time_to_reach(&self, error: f64) -> Option<Interval> {
        bootstrap([self], |[means]| time_to_reach(means, error))
    }

    /// 1 / (error · time) of the last point: samples of a method that is twice as efficient are worth twice as much.
    pub fn efficiency(&self) -> Option<Interval> {
        bootstrap([self], |[means]| means.last().filter(|(_, error)| *error > 0.0).map(|(t, error)| 1.0 / (t * error)))
    }
}

/// Seconds at which the error of `late` becomes and stays less than that of `early`; `None` if it is so from the start or never.
pub fn overtakes(late: &Curve, early: &Curve) -> Option<Interval> {
    bootstrap([late, early], |[late, early]| crossing(late, early))
}

/// The ratio of the efficiency of one method to that of another.
pub fn relative_efficiency(of: &Curve, to: &Curve) -> Option<Interval> {
    bootstrap([of, to], |[of, to]| {
        let (of, to) = (of.last()?, to.last()?);
        (of.1 > 0.0 && to.1 > 0.0).then(|| to.0 * to.1 / (of.0 * of.1))
    })
}

/// A number that follows from the points of some curves, with what drawing the replicas again makes of it.
fn bootstrap<const N: usize>(curves: [&Curve; N], of: impl Fn([&[Mean]; N]) -> Option<f64>) -> Option<Interval> {
    let means = curves.map(Curve::means);
    let value = of(std::array::from_fn(|i| &means[i][..])).filter(|value| value.is_finite())?;
    let mut rng = Pcg64::new(0x5eed, 0xb007);
    let draws: Vec<f64> = (0..DRAWS)
        .filter_map(|_| {
            let means = curves.map(|curve| curve.drawn(&mut rng));
            of(std::array::from_fn(|i| &means[i][..])).filter(|value| value.is_finite())
        })
        .collect();
    interval(value, draws)
}

/// The interval of a value from what the draws make of it.
fn interval(value: f64, mut draws: Vec<f64>) -> Option<Interval> {
    if (draws.len() as f64) < EXISTS * DRAWS as f64 {
        return None;
    }
    draws.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| draws[((draws.len() - 1) as f64 * share).round() as usize];
    let mean = draws.iter().sum::<f64>() / draws.len() as f64;
    let variance = draws.iter().map(|draw| (draw - mean).powi(2)).sum::<f64>() / (draws.len() - 1) as f64;
    Some(Interval { value, low: at(0.025), high: at(0.975), error: variance.sqrt() })
}

/// A number that follows from `n` independent replicas, which are given by their indices, with the same replicas drawn again and
/// again. What is measured in pairs stays in pairs.
pub fn resampled(n: usize, of: impl Fn(&[usize]) -> Option<f64>) -> Option<Interval> {
    let mut indices: Vec<usize> = (0..n).collect();
    let value = of(&indices).filter(|value| value.is_finite())?;
    let mut rng = Pcg64::new(0x5eed, 0xb007);
    let draws = (0..DRAWS).filter_map(|_| {
        indices.fill_with(|| index(&mut rng, n));
        of(&indices).filter(|value| value.is_finite())
    });
    interval(value, draws.collect())
}

/// The mean of independent values.
pub fn mean(values: &[f64]) -> Option<Interval> {
    resampled(values.len(), |indices| Some(mean_at(values, indices)))
}

/// The mean of some values over that of others, which were measured in pairs with them.
pub fn ratio(of: &[f64], to: &[f64]) -> Option<Interval> {
    resampled(of.len().min(to.len()), |indices| Some(mean_at(of, indices) / mean_at(to, indices)))
}

fn mean_at(values: &[f64], indices: &[usize]) -> f64 {
    indices.iter().map(|i| values[*i]).sum::<f64>() / indices.len() as f64
}

fn logarithms(means: &[Mean]) -> impl Iterator<Item = (f64, f64)> + Clone {
    means.iter().filter(|(t, error)| *t > 0.0 && *error > 0.0).map(|(t, error)| (t.ln(), error.ln()))
}

/// A straight line through points on logarithmic axes.
struct Line {
    slope: f64,
    /// Standard error of the slope, from the scatter of the points about the line.
    error: f64,
}

fn line(means: &[Mean]) -> Option<Line> {
    let points = logarithms(means);
    let n = points.clone().count();
    if n < 3 {
        return None;
    }
    let n = n as f64;
    let (mx, my) = points.clone().fold((0.0, 0.0), |(x, y), (a, b)| (x + a / n, y + b / n));
    let (xx, xy) =
        points.clone().fold((0.0, 0.0), |(xx, xy), (x, y)| (xx + (x - mx) * (x - mx), xy + (x - mx) * (y - my)));
    let slope = xy / xx;
    let scatter: f64 = points.map(|(x, y)| (y - my - slope * (x - mx)).powi(2)).sum();
    Some(Line { slope, error: (scatter / (n - 2.0) / xx).sqrt() })
}

fn time_to_reach(means: &[Mean], error: f64) -> Option<f64> {
    let points: Vec<(f64, f64)> = logarithms(means).collect();
    let goal = error.ln();
    let above = points.iter().rposition(|point| point.1 > goal)?;
    let pair = points.get(above..above + 2)?;
    let share = (pair[0].1 - goal) / (pair[0].1 - pair[1].1);
    Some((pair[0].0 + share * (pair[1].0 - pair[0].0)).exp())
}

/// The logarithm of a curve's error at a logarithm of time within its points.
fn error_at(points: &[(f64, f64)], t: f64) -> Option<f64> {
    let pair = points.windows(2).find(|pair| (pair[0].0..=pair[1].0).contains(&t))?;
    let share = if pair[1].0 > pair[0].0 { (t - pair[0].0) / (pair[1].0 - pair[0].0) } else { 0.0 };
    Some(pair[0].1 + share * (pair[1].1 - pair[0].1))
}

fn crossing(late: &[Mean], early: &[Mean]) -> Option<f64> {
    let (late, early): (Vec<_>, Vec<_>) = (logarithms(late).collect(), logarithms(early).collect());
    let mut times: Vec<f64> = late.iter().chain(&early).map(|(t, _)| *t).collect();
    times.sort_unstable_by(f64::total_cmp);
    let gaps: Vec<(f64, f64)> =
        times.iter().filter_map(|t| Some((*t, error_at(&late, *t)? - error_at(&early, *t)?))).collect();
    // The last change of sign, if it ends below.
    if gaps.last()?.1 >= 0.0 {
        return None;
    }
    let pair = gaps.windows(2).rev().find(|pair| pair[0].1 >= 0.0)?;
    let share = pair[0].1 / (pair[0].1 - pair[1].1);
    Some((pair[0].0 + share * (pair[1].0 - pair[0].0)).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number that is uniform on [0, 1).
    fn uniform(rng: &mut Pcg64) -> f64 {
        (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Replicas with errors factor · t^slope, times noise.
    fn curve(name: &str, factor: f64, slope: f64, noise: f64) -> Curve {
        let mut rng = Pcg64::new(7, name.len() as u128);
        let mut uniform = move || uniform(&mut rng);
        let mut sample = |t: f64| {
            let error = factor * t.powf(slope) * (1.0 + noise * (uniform() + uniform() + uniform() + uniform() - 2.0));
            Sample { seconds: t, error }
        };
        let points = (0..9).map(|i| (0..8).map(|_| sample(0.25 * 2f64.powi(i))).collect()).collect();
        Curve { name: name.into(), points }
    }

    #[test]
    fn what_follows_from_exact_curves_is_exact() {
        let (slow, fast) = (curve("slow", 0.01, -0.5, 0.0), curve("fast", 0.03, -1.0, 0.0));
        let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
        let slope = fast.slope().unwrap();
        assert!(close(slope.value, -1.0) && slope.error < 1e-12);
        assert!(close(fast.time_to_reach(0.01).unwrap().value, 3.0));
        assert_eq!(fast.time_to_reach(1e-6), None, "beyond the last point");
        assert_eq!(fast.time_to_reach(1.0), None, "before the first point");
        // One point in the middle that is as bad as the first.
        let mut rough = fast.clone();
        rough.points[4] = rough.points[0].clone();
        rough.points[4].iter_mut().for_each(|sample| sample.seconds = fast.points[4][0].seconds);
        let (more, less) = (rough.time_to_reach(0.05).unwrap().value, rough.time_to_reach(0.01).unwrap().value);
        let bad = fast.points[4][0].seconds;
        assert!(bad < more && more < less && less < 2.0 * bad, "{bad} {more} {less}");
        // 0.03 / t = 0.01 / sqrt(t) at t = 9.
        assert!(close(overtakes(&fast, &slow).unwrap().value, 9.0));
        assert_eq!(overtakes(&slow, &fast), None);
        // At 64 s: 0.01 / 8 against 0.03 / 64.
        assert!(close(relative_efficiency(&fast, &slow).unwrap().value, (0.01 / 8.0) / (0.03 / 64.0)));
    }

    #[test]
    fn intervals_hold_the_truth_about_as_often_as_they_say() {
        let (mut slopes, mut errors, mut narrow, n) = (0, 0, 0, 200);
        for i in 0..n {
            // The length of the name is the seed.
            let noisy = curve(&"x".repeat(i + 1), 0.02, -1.0, 0.6);
            let slope = noisy.slope().unwrap();
            slopes += usize::from(slope.low <= -1.0 && -1.0 <= slope.high);
            let last = noisy.errors()[8];
            let truth = 0.02 / 64.0;
            errors += usize::from(last.low <= truth && truth <= last.high);
            // Intervals a third as wide are wrong more often.
            narrow += usize::from((slope.value + 1.0).abs() <= (slope.high - slope.low) / 6.0);
        }
        // 190 are right; without the stretch of what is drawn again, errors are so 174 times.
        assert!(slopes > 180 && errors > 176, "{slopes} {errors}");
        assert!(narrow < 120, "{narrow}");
    }

    #[test]
    fn slopes_know_of_a_machine_whose_speed_changes_between_budgets() {
        let (mut right, mut by_replicas_alone, n) = (0, 0, 200);
        for i in 0..n {
            let mut noisy = curve(&"y".repeat(i + 1), 0.02, -1.0, 0.02);
            // All replicas of a budget are up to a tenth faster or slower than others.
            let mut rng = Pcg64::new(11, i as u128);
            for point in &mut noisy.points {
                let speed = 0.9 + 0.2 * uniform(&mut rng);
                point.iter_mut().for_each(|sample| sample.seconds /= speed);
            }
            let holds = |slope: Interval| usize::from(slope.low <= -1.0 && -1.0 <= slope.high);
            right += holds(noisy.slope().unwrap());
            by_replicas_alone += holds(bootstrap([&noisy], |[means]| Some(line(means)?.slope)).unwrap());
        }
        assert!(right > 174, "{right}");
        assert!(by_replicas_alone < 60, "{by_replicas_alone}");
    }

    #[test]
    fn methods_that_differ_are_told_apart_and_equal_ones_are_not() {
        let (a, b, worse) =
            (curve("a", 0.02, -1.0, 0.3), curve("bb", 0.02, -1.0, 0.3), curve("worse", 0.04, -1.0, 0.3));
        let last = |curve: &Curve| curve.errors()[8];
        assert!(last(&a).is_apart_from(&last(&worse)) && !last(&a).is_apart_from(&last(&b)));
        let ratio = relative_efficiency(&a, &worse).unwrap();
        assert!(ratio.low > 1.2 && ratio.high < 3.2, "{ratio:?}");
    }

    #[test]
    fn pairs_cancel_what_they_have_in_common() {
        let mut rng = Pcg64::new(3, 5);
        let mut uniform = move || uniform(&mut rng);
        // A machine that is up to ten times slower now and then, for both.
        let slowness: Vec<f64> = (0..40).map(|_| 1.0 + 9.0 * uniform()).collect();
        let one: Vec<f64> = slowness.iter().map(|s| 2.0 * s * (0.99 + 0.02 * uniform())).collect();
        let pair = ratio(&one, &slowness).unwrap();
        assert!(pair.low <= 2.0 && 2.0 <= pair.high && pair.high - pair.low < 0.02, "{pair:?}");
        let apart = mean(&one).unwrap();
        assert!(apart.high / apart.low > 1.2, "{apart:?}");
        let normal: Vec<f64> = (0..400).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect();
        let centre = mean(&normal).unwrap();
        assert!((centre.error / 0.05 - 1.0).abs() < 0.2 && centre.low < 0.0 && 0.0 < centre.high, "{centre:?}");
        assert_eq!(ratio(&one, &[0.0; 40]), None, "infinite");
    }
}
