//! By how much density raises the collision rate.

use std::f64::consts::FRAC_PI_4;

use serde::{Deserialize, Serialize};
use stosszahl_model::kinetic;

/// Over which area the packing fraction is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Neighbourhood {
    /// The whole box.
    Mean,
    /// The square of (2n + 1)^2 cells around.
    Cells(u32),
}

/// The factor chi on the collision rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Scheme {
    /// chi = 1: the dilute gas. Converges to the Boltzmann equation.
    Boltzmann,
    /// chi = V/(V - `V_0`), `V_0` the area that the disks of the cell need at random close packing, 0.82:
    /// the scheme of Luding, Müller & McNamara (1998). 9 % below Enskog at packing 0.25; without a
    /// limit it is infinite or negative in a crowded cell.
    FreeVolume,
    /// chi of the packing around the cell: with many simulators the local Enskog collision rate.
    Enskog(Neighbourhood),
}

impl Scheme {
    /// The word used in file names and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Boltzmann => "boltzmann",
            Self::FreeVolume => "free-volume",
            Self::Enskog(_) => "enskog",
        }
    }

    /// chi at a packing fraction, before any limit.
    pub fn contact_value(self, packing_fraction: f64) -> f64 {
        match self {
            Self::Boltzmann => 1.0,
            Self::FreeVolume => kinetic::free_volume_factor(packing_fraction),
            Self::Enskog(_) => kinetic::contact_value(packing_fraction),
        }
    }
}

/// Most entries of the table of chi: beyond, in huge cells, it is computed.
const LARGEST_TABLE: u32 = 1 << 14;

/// chi in each cell, from how much area its neighbourhood's disks cover.
#[derive(Debug)]
pub(crate) struct Density {
    scheme: Scheme,
    limit: f64,
    /// chi by the number of unit areas in the neighbourhood: the covered area is a small integer times
    /// one disk's where all are alike, so chi is looked up.
    table: Vec<f64>,
    /// Packing fraction of one unit of area in the neighbourhood.
    unit: f64,
    /// Half width of the neighbourhood in cells.
    reach: usize,
    mean: Option<f64>,
    mean_packing: f64,
    counts: [usize; 2],
    /// Area around each cell, in units.
    around: Vec<f64>,
    rows: Vec<f64>,
}

impl Density {
    /// `cell`: area of a cell; `unit_diameter`: of the disk whose area, times `weight`, is the unit;
    /// `packing_fraction`: of the whole box.
    pub(crate) fn new(
        scheme: Scheme,
        limit: f64,
        counts: [usize; 2],
        cell: f64,
        unit_diameter: f64,
        weight: f64,
        packing_fraction: f64,
    ) -> Self {
        let reach = match scheme {
            // A neighbourhood that wraps around the box would count disks twice.
            Scheme::Enskog(Neighbourhood::Cells(n)) => {
                (n as usize).min((counts[0].min(counts[1]) - 1) / 2)
            }
            _ => 0,
        };
        let mean = match scheme {
            Scheme::Enskog(Neighbourhood::Mean) => Some(scheme.contact_value(packing_fraction)),
            Scheme::Boltzmann => Some(1.0),
            _ => None,
        };
        let area = cell * ((2 * reach + 1) * (2 * reach + 1)) as f64;
        let unit = weight * FRAC_PI_4 * unit_diameter * unit_diameter / area;
        let table = if mean.is_some() { 0 } else { LARGEST_TABLE };
        let table = (0..table)
            .map(|count| scheme.contact_value(f64::from(count) * unit))
            .take_while(|&chi| chi < limit)
            .collect();
        Self {
            scheme,
            limit,
            table,
            unit,
            reach,
            mean,
            mean_packing: if scheme == Scheme::Boltzmann {
                0.0
            } else {
                packing_fraction
            },
            counts,
            around: Vec::new(),
            rows: Vec::new(),
        }
    }

    /// Takes the area covered in each cell, in units of one disk's.
    pub(crate) fn update(&mut self, areas: impl Iterator<Item = f64>) {
        if self.mean.is_some() {
            return;
        }
        self.around.clear();
        self.around.extend(areas);
        if self.reach == 0 {
            return;
        }
        let [columns, rows] = self.counts;
        self.rows.resize(self.around.len(), 0.0);
        for row in 0..rows {
            let line = row * columns..(row + 1) * columns;
            window_sums(
                &self.around[line.clone()],
                self.reach,
                1,
                &mut self.rows[line],
            );
        }
        for column in 0..columns {
            window_sums(
                &self.rows[column..],
                self.reach,
                columns,
                &mut self.around[column..],
            );
        }
    }

    /// chi of a cell, and whether it was limited.
    #[inline]
    pub(crate) fn contact_value(&self, cell: usize) -> (f64, bool) {
        if let Some(chi) = self.mean {
            return (chi.min(self.limit), chi > self.limit);
        }
        let area = self.around[cell];
        let known = if area.fract() == 0.0 {
            self.table.get(area as usize)
        } else {
            None
        };
        let chi = known
            .copied()
            .unwrap_or_else(|| self.scheme.contact_value(area * self.unit));
        (chi.min(self.limit), chi >= self.limit)
    }

    /// Packing fraction that chi of a cell belongs to; none for the dilute gas.
    #[inline]
    pub(crate) fn packing(&self, cell: usize) -> f64 {
        self.around
            .get(cell)
            .map_or(self.mean_packing, |area| area * self.unit)
    }
}

/// Sums over periodic windows of `2 reach + 1` elements; elements are `stride` apart.
fn window_sums(values: &[f64], reach: usize, stride: usize, sums: &mut [f64]) {
    let count = values.len().div_ceil(stride);
    let at = |index: usize| values[(index % count) * stride];
    let mut sum: f64 = (0..=2 * reach).map(|step| at(count - reach + step)).sum();
    for index in 0..count {
        sums[index * stride] = sum;
        // Integers stay exact, so sliding leaves no trace; unlike disks keep it within rounding.
        sum += at(index + reach + 1) - at(index + count - reach);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_periodic_sums() {
        let values = [1.0, 2.0, 3.0, 4.0, 5.0];
        let mut sums = [0.0; 5];
        window_sums(&values, 1, 1, &mut sums);
        assert_eq!(sums, [8.0, 6.0, 9.0, 12.0, 10.0]);
        window_sums(&values, 2, 1, &mut sums);
        assert_eq!(sums, [15.0; 5]);
    }

    /// The sliding sums over the grid against the plain double sum.
    #[test]
    fn neighbourhood_packing_is_the_plain_sum() {
        let counts = [7, 5];
        let areas: Vec<f64> = (0..35).map(|i| f64::from(i * i % 4)).collect();
        let scheme = Scheme::Enskog(Neighbourhood::Cells(2));
        let mut density = Density::new(scheme, 10.0, counts, 4.0, 1.0, 1.0, 0.25);
        density.update(areas.iter().copied());
        for row in 0..5 {
            for column in 0..7 {
                let mut plain = 0.0;
                for y in 0..5 {
                    for x in 0..5 {
                        plain += areas[((row + y + 3) % 5) * 7 + (column + x + 5) % 7];
                    }
                }
                let packing = plain * FRAC_PI_4 / 100.0;
                let cell = row * 7 + column;
                assert!((density.packing(cell) - packing).abs() < 1e-14);
                assert!(
                    (density.contact_value(cell).0 - kinetic::contact_value(packing)).abs() < 1e-12
                );
            }
        }
    }

    #[test]
    fn crowded_cells_are_limited_and_say_so() {
        let mut density = Density::new(Scheme::FreeVolume, 10.0, [2, 1], 4.0, 1.0, 1.0, 0.25);
        density.update([2.0, 5.0].into_iter());
        let (chi, limited) = density.contact_value(0);
        assert!(!limited && (chi - 1.0 / (1.0 - FRAC_PI_4 / 2.0 / 0.82)).abs() < 1e-14);
        assert_eq!(density.contact_value(1), (10.0, true));
    }
}
