// SPDX-License-Identifier: MIT OR Apache-2.0
//! The constants of one Kelvin-Voigt material and the moduli that follow from them (the paper's Eq. (6)).

/// Elastic constants and viscosities of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus `E > 0`, pressure.
    pub youngs_modulus: f64,
    /// Poisson's ratio, `-1 < nu <= 1/2`.
    pub poissons_ratio: f64,
    /// Shear (deviatoric) viscosity `eta1 >= 0`, pressure x time.
    pub shear_viscosity: f64,
    /// Bulk viscosity `eta2 >= 0`, pressure x time.
    pub bulk_viscosity: f64,
}

impl Material {
    /// `c = (1 - nu^2)/E`: the body's share of `1/E*`.
    pub fn normal_compliance(&self) -> f64 {
        (1.0 - self.poissons_ratio * self.poissons_ratio) / self.youngs_modulus
    }
    /// Shear modulus `G = E/(2(1+nu))`.
    pub fn shear_modulus(&self) -> f64 {
        0.5 * self.youngs_modulus / (1.0 + self.poissons_ratio)
    }
    /// `tau1 = eta1/E1`, `E1 = E/(1+nu) = 2G`: relaxation time in shear.
    pub fn shear_relaxation_time(&self) -> f64 {
        self.shear_viscosity * (1.0 + self.poissons_ratio) / self.youngs_modulus
    }
    /// `tau2 = eta2/E2`, `E2 = E/(3(1-2nu))`: relaxation time in bulk; 0 for an incompressible solid.
    pub fn bulk_relaxation_time(&self) -> f64 {
        3.0 * self.bulk_viscosity * (1.0 - 2.0 * self.poissons_ratio) / self.youngs_modulus
    }
}
