// SPDX-License-Identifier: MIT OR Apache-2.0
//! One material, and the words that say it to each pair style. The built-in styles take spring and damping
//! constants, which must be fitted to one mass and one size: that is done here, as a careful user would.

/// SI units.
pub struct Material {
    pub youngs_modulus: f64,
    pub poissons_ratio: f64,
    /// Shear and bulk viscosity, here the same.
    pub viscosity: f64,
    pub density: f64,
    pub friction: f64,
}

impl Material {
    /// E* of two grains of it.
    pub fn effective_modulus(&self) -> f64 {
        self.youngs_modulus / (2.0 * (1.0 - self.poissons_ratio.powi(2)))
    }

    /// A_n, energy closure.
    pub fn relaxation_time(&self) -> f64 {
        let nu = self.poissons_ratio;
        let shear = 2.0 / 3.0 * (1.0 - nu + nu * nu);
        let bulk = (1.0 - 2.0 * nu).powi(2);
        self.viscosity * (shear + bulk) / (1.0 - nu).powi(2) * (1.0 - nu * nu) / self.youngs_modulus
    }

    pub fn mass(&self, volume: f64) -> f64 {
        self.density * volume
    }

    /// `pair_coeff` words of gran/ellipsoid.
    pub fn viscoelastic(&self) -> String {
        format!(
            "nfd {} {} {} {}",
            self.youngs_modulus, self.poissons_ratio, self.viscosity, self.viscosity
        )
    }

    pub fn elastic(&self) -> String {
        format!("hertz {} {}", self.youngs_modulus, self.poissons_ratio)
    }

    pub fn with_friction(&self, normal: &str) -> String {
        format!("{normal} tangential tfd {}", self.friction)
    }

    /// `pair_coeff` words of the built-in granular style; `mass` of one grain, `None` for no damping.
    pub fn granular(&self, mass: Option<f64>, friction: f64) -> String {
        let eta = mass.map_or(0.0, |mass| self.damping_constant(mass));
        let mindlin = i32::from(mass.is_some());
        format!(
            "hertz/material {} {eta} {} tangential mindlin NULL {mindlin} {friction} damping viscoelastic",
            self.youngs_modulus, self.poissons_ratio
        )
    }

    /// `pair_coeff` words of granular/superellipsoid, its tangential spring fitted at one contact radius.
    pub fn superellipsoid(&self, mass: Option<f64>, friction: f64, contact_radius: f64) -> String {
        let eta = mass.map_or(0.0, |mass| self.damping_constant(mass));
        let tangential = i32::from(mass.is_some());
        format!(
            "hertz {} {eta} tangential linear_history {} {tangential} {friction} damping viscoelastic",
            4.0 / 3.0 * self.effective_modulus(),
            self.tangential_stiffness(contact_radius)
        )
    }

    /// Makes the built-in damping, eta a m_eff v, the first-order viscous force A_n dF_H/d(delta) v = 2 E* A_n a v
    /// for two grains of this mass.
    fn damping_constant(&self, mass: f64) -> f64 {
        2.0 * self.effective_modulus() * self.relaxation_time() / (0.5 * mass)
    }

    /// Mindlin's initial stiffness of two equal grains on a circle of this radius.
    pub fn tangential_stiffness(&self, contact_radius: f64) -> f64 {
        let shear_modulus = self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio));
        4.0 * shear_modulus * contact_radius / (2.0 - self.poissons_ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_constants_are_those_of_the_theory() {
        let unit = Material {
            youngs_modulus: 1.0,
            poissons_ratio: 0.3,
            viscosity: 1.0,
            density: 1.0,
            friction: 0.5,
        };
        // The energy closure at E = 1, nu = 0.3, both viscosities 1.
        assert!((unit.relaxation_time() - 1.275_238).abs() < 1e-6);
        assert!((unit.effective_modulus() - 1.0 / 1.82).abs() < 1e-15);
    }
}
