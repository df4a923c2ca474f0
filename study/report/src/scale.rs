//! Axis scales, linear and logarithmic: positions of values on an axis, and ticks at round numbers.

use stosszahl_results::AxisScale;

use crate::words::{number, power};

/// Largest magnitude of a value that is drawn, so that sums and squares stay finite.
const LARGEST: f64 = 1e100;

/// Range of an axis and its scale, linear or logarithmic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AxisRange {
    scale: AxisScale,
    /// Lower end of the range; on a logarithmic scale its decimal logarithm.
    low: f64,
    /// Upper end of the range; on a logarithmic scale its decimal logarithm.
    high: f64,
}

/// Tick of an axis: its position from 0 to 1, and its label; minor ticks have none.
pub(crate) type Tick = (f64, Option<String>);

/// Returns true if a value can be drawn on a scale: finite, and positive on a logarithmic scale.
pub(crate) fn shows(scale: AxisScale, value: f64) -> bool {
    value.abs() <= LARGEST && (scale == AxisScale::Linear || value >= 1.0 / LARGEST)
}

/// Returns smallest and largest of the values that can be drawn on a scale; `None` if there are
/// none.
pub(crate) fn extent(scale: AxisScale, values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let shown = values.filter(|value| shows(scale, *value));
    shown.fold(None, |range, value| {
        let (low, high) = range.unwrap_or((value, value));
        Some((value.min(low), value.max(high)))
    })
}

impl AxisRange {
    /// Creates an axis range around data, with some margin unless `exact`.
    pub fn range_around(scale: AxisScale, (low, high): (f64, f64), exact: bool) -> Self {
        if exact && high > low {
            return match scale {
                AxisScale::Linear => Self { scale, low, high },
                AxisScale::Logarithmic => Self {
                    scale,
                    low: low.log10(),
                    high: high.log10(),
                },
            };
        }
        match scale {
            AxisScale::Linear => {
                // A single value gets a range of a fifth of its size.
                let least = if high > low { 1e-6 } else { 0.2 };
                let span = (high - low)
                    .max(least * high.abs().max(low.abs()))
                    .max(1e-12);
                let middle = 0.5 * (low + high);
                let mut ends = [middle - 0.56 * span, middle + 0.56 * span];
                // The range extends to zero if that is close, and not across zero.
                if low >= 0.0 && ends[0] < 0.25 * span {
                    ends[0] = 0.0;
                } else if high <= 0.0 && ends[1] > -0.25 * span {
                    ends[1] = 0.0;
                }
                Self {
                    scale,
                    low: ends[0],
                    high: ends[1],
                }
            }
            AxisScale::Logarithmic => {
                let (mut low, mut high) = (low.log10() - 0.08, high.log10() + 0.08);
                // A power of ten close by gets a label.
                if low - low.floor() < 0.2 {
                    low = low.floor();
                }
                if high.ceil() - high < 0.2 {
                    high = high.ceil();
                }
                // A range of less than a factor of three is widened, so that it has at least two
                // labels.
                let missing = (3_f64.log10() - (high - low)).max(0.0);
                Self {
                    scale,
                    low: low - 0.5 * missing,
                    high: high + 0.5 * missing,
                }
            }
        }
    }

    /// Returns both ends of the range, in units of the data.
    pub fn ends(&self) -> [f64; 2] {
        match self.scale {
            AxisScale::Linear => [self.low, self.high],
            AxisScale::Logarithmic => [self.low, self.high].map(|end| 10_f64.powf(end)),
        }
    }

    /// Returns the position of a value, from 0 to 1 inside the range; `None` if it cannot be drawn.
    pub fn position_of(&self, value: f64) -> Option<f64> {
        let value = match self.scale {
            _ if !shows(self.scale, value) => return None,
            AxisScale::Linear => value,
            AxisScale::Logarithmic => value.log10(),
        };
        Some((value - self.low) / (self.high - self.low))
    }

    /// Returns the position of a value, clamped to 0 to 1.
    pub fn clamped(&self, value: f64) -> f64 {
        self.position_of(value).unwrap_or(0.0).clamp(0.0, 1.0)
    }

    /// Returns the ticks of the axis: major ticks with labels, minor ticks without.
    pub fn ticks(&self) -> Vec<Tick> {
        match self.scale {
            AxisScale::Linear => self.linear_ticks(),
            AxisScale::Logarithmic => self.logarithmic_ticks(),
        }
    }

    fn linear_ticks(&self) -> Vec<Tick> {
        let span = self.high - self.low;
        let step = step(span);
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let plain = decimals <= 4 && self.high.abs().max(self.low.abs()) < 1e5;
        let first = (self.low / step - 1e-9).ceil();
        let count = ((self.high / step + 1e-9).floor() - first).clamp(0.0, 20.0) as usize;
        let ticks = (0..=count).map(|i| (first + i as f64) * step);
        let label = |value: f64| {
            if value.abs() < 1e-6 * step {
                return "0".to_owned();
            }
            if plain {
                return format!("{value:.decimals$}").replace('-', "−");
            }
            // As many digits as distinguish adjacent ticks.
            let digits = (value.abs() / step).log10().floor().clamp(0.0, 12.0) as usize + 2;
            number(value, digits)
        };
        ticks
            .map(|value| ((value - self.low) / span, Some(label(value))))
            .collect()
    }

    fn logarithmic_ticks(&self) -> Vec<Tick> {
        let span = self.high - self.low;
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let stride = ((span / 7.0).ceil() as i32).max(1);
        let plain = self.low > -2.1 && self.high < 4.1;
        let factors: &[u8] = match () {
            () if span < 1.1 => &[1, 2, 3, 4, 5, 6, 7, 8, 9],
            () if span < 2.2 => &[1, 2, 5],
            () => &[1],
        };
        let mut ticks = Vec::new();
        for exponent in first..=last {
            for factor in 1..=9_u8 {
                if factor > 1 && span > 8.0 {
                    break;
                }
                let place = (f64::from(exponent) + f64::from(factor).log10() - self.low) / span;
                if !(-1e-9..=1.0 + 1e-9).contains(&place) {
                    continue;
                }
                let crowded = span > 0.6 && [7, 9].contains(&factor);
                let labelled = factors.contains(&factor)
                    && !crowded
                    && (factor > 1 || exponent.rem_euclid(stride) == 0);
                let label = || {
                    let value = f64::from(factor) * 10_f64.powi(exponent);
                    match factor {
                        _ if plain => number(value, 1),
                        1 if exponent == 0 => "1".to_owned(),
                        1 => power(exponent),
                        _ => format!("{factor}·{}", power(exponent)),
                    }
                };
                if labelled || span < 30.0 {
                    ticks.push((place, labelled.then(label)));
                }
            }
        }
        ticks
    }
}

/// Returns a tick step of 1, 2 or 5 times a power of ten that divides `span` into three to eight
/// parts.
fn step(span: f64) -> f64 {
    let raw = span / 5.0;
    let power = 10_f64.powf(raw.log10().floor());
    let multiple = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|multiple| multiple * power >= raw * 0.999);
    multiple.unwrap_or(10.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: AxisScale, low: f64, high: f64) -> Vec<String> {
        let ticks = AxisRange::range_around(scale, (low, high), false).ticks();
        ticks.into_iter().filter_map(|tick| tick.1).collect()
    }

    #[test]
    fn ticks_are_those_that_one_would_draw() {
        assert_eq!(labels(AxisScale::Linear, 0.0, 1.0), ["0", "0.5", "1.0"]);
        assert_eq!(
            labels(AxisScale::Linear, -1.0, 1.0),
            ["−1.0", "−0.5", "0", "0.5", "1.0"]
        );
        assert_eq!(
            labels(AxisScale::Logarithmic, 1e-5, 1.0),
            ["10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "1"]
        );
        assert_eq!(
            labels(AxisScale::Logarithmic, 1.0, 30.0),
            ["1", "2", "5", "10", "20"]
        );
    }

    #[test]
    fn no_data_breaks_a_frame() {
        for scale in [AxisScale::Linear, AxisScale::Logarithmic] {
            for (low, high) in [(1.0, 1.0), (1e-100, 1e100), (1e-12, 2e-12), (1e99, 1e100)] {
                let frame = AxisRange::range_around(scale, (low, high), false);
                let ticks = frame.ticks();
                assert!((2..100).contains(&ticks.len()), "{low} {high}: {ticks:?}");
                for (place, _) in ticks {
                    assert!((-0.01..=1.01).contains(&place));
                }
                assert!(
                    frame
                        .position_of(low)
                        .is_some_and(|place| (0.0..=1.0).contains(&place))
                );
            }
        }
        assert_eq!(
            AxisRange::range_around(AxisScale::Linear, (0.0, 0.0), false).clamped(f64::NAN),
            0.0
        );
    }
}
