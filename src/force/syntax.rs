// SPDX-License-Identifier: MIT OR Apache-2.0
//! The words of an input deck that choose a law: what follows `I J` in `pair_coeff`, or the fix style of a wall.
//!
//! ```text
//! <normal> [damping ...] [tangential ...] [keywords]
//!   normal:      hertz E nu | nfd E nu eta1 eta2 | lsd kn cn
//!   damping:     damping restitution e | damping relaxation A_n | damping none
//!   tangential:  tangential none | tfd mu | mindlin mu | linear kt ct mu
//!   keywords:    closure energy|surface|brilliantov    unloading ting|first_order    displacement total|incremental|rescaled
//!                factors exact|hale    conservative yes|no    limit_force yes|no
//! ```

use super::parameters::{
    Closure, Damping, Displacement, FactorForm, LawParameters, Normal, ParameterError, Tangential,
    Unloading, LARGEST_CONSTANT,
};

struct Words<'a> {
    words: &'a [&'a str],
    position: usize,
}

impl<'a> Words<'a> {
    fn next(&mut self, after: &str, what: &str) -> Result<&'a str, ParameterError> {
        let word = self.words.get(self.position).ok_or_else(|| {
            ParameterError(format!(
                "'{after}' must be followed by {what}: a word is missing"
            ))
        })?;
        self.position += 1;
        Ok(word)
    }

    fn number(&mut self, after: &str, what: &str) -> Result<f64, ParameterError> {
        let word = self.next(after, what)?;
        word.parse().map_err(|_| {
            ParameterError(format!(
                "'{after}' must be followed by {what}: '{word}' is not a number"
            ))
        })
    }

    fn choice<T: Copy>(&mut self, after: &str, choices: &[(&str, T)]) -> Result<T, ParameterError> {
        let names: Vec<&str> = choices.iter().map(|c| c.0).collect();
        let word = self.next(after, &names.join("|"))?;
        choices
            .iter()
            .find(|c| c.0 == word)
            .map(|c| c.1)
            .ok_or_else(|| {
                ParameterError(format!(
                    "unknown word '{word}' after '{after}': expected {}",
                    names.join("|")
                ))
            })
    }
}

const NORMAL_LAWS: [(&str, Normal); 3] = [
    ("hertz", Normal::Hertz),
    ("nfd", Normal::Nfd),
    ("lsd", Normal::Lsd),
];
const DAMPINGS: [(&str, Damping); 3] = [
    ("none", Damping::None),
    ("restitution", Damping::Restitution),
    ("relaxation", Damping::Relaxation),
];
const TANGENTIAL_LAWS: [(&str, Tangential); 4] = [
    ("none", Tangential::None),
    ("tfd", Tangential::Tfd),
    ("mindlin", Tangential::Mindlin),
    ("linear", Tangential::Linear),
];
const CLOSURES: [(&str, Closure); 3] = [
    ("energy", Closure::Energy),
    ("surface", Closure::Surface),
    ("brilliantov", Closure::Brilliantov),
];
const UNLOADINGS: [(&str, Unloading); 2] = [
    ("ting", Unloading::Ting),
    ("first_order", Unloading::FirstOrder),
];
const DISPLACEMENTS: [(&str, Displacement); 3] = [
    ("total", Displacement::Total),
    ("incremental", Displacement::Incremental),
    ("rescaled", Displacement::Rescaled),
];
const FACTORS: [(&str, FactorForm); 2] = [("exact", FactorForm::Exact), ("hale", FactorForm::Hale)];
const YES_NO: [(&str, bool); 2] = [("yes", true), ("no", false)];

/// The keyword that a word belongs behind, if there is one: `tangential` for `tfd`.
fn keyword_of(word: &str) -> Option<&'static str> {
    fn has<T>(choices: &[(&str, T)], word: &str) -> bool {
        choices.iter().any(|(name, _)| *name == word)
    }
    // `none` belongs behind two of them and tells nothing.
    if word == "none" {
        None
    } else if has(&TANGENTIAL_LAWS, word) {
        Some("tangential")
    } else if has(&DAMPINGS, word) {
        Some("damping")
    } else if has(&CLOSURES, word) {
        Some("closure")
    } else if has(&UNLOADINGS, word) {
        Some("unloading")
    } else if has(&DISPLACEMENTS, word) {
        Some("displacement")
    } else if has(&FACTORS, word) {
        Some("factors")
    } else {
        None
    }
}

/// Reads the words of a law up to the first that is not one of its keywords, and checks the constants.
///
/// Returns the parameters and the number of words read. Where `conservative` is not given it is `yes`, but `no` with
/// `factors hale`; all else that is not given is that of `LawParameters::default`.
///
/// # Errors
/// A word that is missing, unknown where a choice is due, not a number, given twice, out of range, or that lacks the keyword
/// it belongs behind; the message names it.
pub fn parse(words: &[&str]) -> Result<(LawParameters, usize), ParameterError> {
    let mut p = LawParameters::default();
    let mut w = Words { words, position: 0 };
    p.normal = w.choice("the normal law", &NORMAL_LAWS)?;
    match p.normal {
        Normal::Hertz | Normal::Nfd => {
            let name = words[0];
            let all = if p.normal == Normal::Nfd {
                "E nu eta1 eta2"
            } else {
                "E nu"
            };
            p.material.youngs_modulus = w.number(name, all)?;
            p.material.poissons_ratio = w.number(name, all)?;
            if p.normal == Normal::Nfd {
                p.material.shear_viscosity = w.number(name, all)?;
                p.material.bulk_viscosity = w.number(name, all)?;
            }
        }
        Normal::Lsd => {
            p.normal_stiffness = w.number("lsd", "kn cn")?;
            p.normal_damping = w.number("lsd", "kn cn")?;
        }
    }
    let mut seen: Vec<&str> = Vec::new();
    let mut conservative = None;
    while let Some(&word) = words.get(w.position) {
        let known = [
            "damping",
            "tangential",
            "closure",
            "unloading",
            "displacement",
            "factors",
            "conservative",
            "limit_force",
        ];
        if !known.contains(&word) {
            match keyword_of(word) {
                Some(keyword) => {
                    return Err(ParameterError(format!(
                        "unknown word '{word}': did you mean '{keyword} {word}'?"
                    )))
                }
                None if NORMAL_LAWS.iter().any(|(name, _)| *name == word) => {
                    return Err(ParameterError(format!(
                        "'{word}' after '{}': there is one normal law, and it comes first",
                        words[0]
                    )))
                }
                None => break,
            }
        }
        if seen.contains(&word) {
            return Err(ParameterError(format!("'{word}' is given twice")));
        }
        seen.push(word);
        w.position += 1;
        match word {
            "damping" => {
                p.damping = w.choice(word, &DAMPINGS)?;
                match p.damping {
                    Damping::None => {}
                    Damping::Restitution => p.restitution = w.number("damping restitution", "e")?,
                    Damping::Relaxation => {
                        p.relaxation_time = w.number("damping relaxation", "A_n")?
                    }
                }
            }
            "tangential" => {
                p.tangential = w.choice(word, &TANGENTIAL_LAWS)?;
                match p.tangential {
                    Tangential::None => {}
                    Tangential::Tfd => p.friction = w.number("tangential tfd", "mu")?,
                    Tangential::Mindlin => p.friction = w.number("tangential mindlin", "mu")?,
                    Tangential::Linear => {
                        p.tangential_stiffness = w.number("tangential linear", "kt ct mu")?;
                        p.tangential_damping = w.number("tangential linear", "kt ct mu")?;
                        p.friction = w.number("tangential linear", "kt ct mu")?;
                    }
                }
            }
            "closure" => {
                p.closure = w.choice(word, &CLOSURES)?;
            }
            "unloading" => {
                p.unloading = w.choice(word, &UNLOADINGS)?;
            }
            "displacement" => {
                p.displacement = w.choice(word, &DISPLACEMENTS)?;
            }
            "factors" => {
                p.factors = w.choice(word, &FACTORS)?;
            }
            "conservative" => conservative = Some(w.choice(word, &YES_NO)?),
            _ => p.limit_force = w.choice(word, &YES_NO)?,
        }
    }
    p.conservative = conservative.unwrap_or(p.factors != FactorForm::Hale);
    p.validate()?;
    Ok((p, w.position))
}

/// Reads the material of a wall, `material ...` in the words of the normal law, or `material rigid`: the parameters of the
/// wall's side of a contact, to be mixed with those of the grain's side, `grain`, of which all else is taken.
///
/// ```text
///   hertz: material E nu    nfd: material E nu eta1 eta2    either: material rigid
/// ```
///
/// `rigid` is a modulus so large that the wall's compliance is below the rounding of the grain's. Returns the parameters and the
/// number of words read; without the word `material` these are `grain` and 0.
///
/// # Errors
/// A word that is missing, not a number or out of range, or a law without a material (`lsd`).
pub fn parse_wall_material(
    grain: &LawParameters,
    words: &[&str],
) -> Result<(LawParameters, usize), ParameterError> {
    if words.first() != Some(&"material") {
        return Ok((*grain, 0));
    }
    let (law, what) = match grain.normal {
        Normal::Hertz => ("material' with 'hertz", "E nu, or by rigid"),
        Normal::Nfd => ("material' with 'nfd", "E nu eta1 eta2, or by rigid"),
        Normal::Lsd => {
            return Err(ParameterError(
                "'material' goes with hertz and nfd: the constants of lsd are those of the contact, wall included"
                    .into(),
            ))
        }
    };
    let mut w = Words { words, position: 1 };
    let mut wall = *grain;
    let m = &mut wall.material;
    if words.get(1) == Some(&"rigid") {
        w.position += 1;
        m.youngs_modulus = LARGEST_CONSTANT;
        (m.shear_viscosity, m.bulk_viscosity) = (0.0, 0.0);
        return Ok((wall, w.position));
    }
    m.youngs_modulus = w.number(law, what)?;
    m.poissons_ratio = w.number(law, what)?;
    if grain.normal == Normal::Nfd {
        m.shear_viscosity = w.number(law, what)?;
        m.bulk_viscosity = w.number(law, what)?;
    }
    wall.validate()
        .map_err(|e| ParameterError(format!("material of the wall: {e}")))?;
    Ok((wall, w.position))
}
