// SPDX-License-Identifier: MIT OR Apache-2.0
//! The words of an input deck that choose a law: what follows `I J` in `pair_coeff`, or the fix style of a wall.
//!
//! `<normal> [damping ...] [tangential ...] [keywords]`: the tables of choices in [`super::parameters`], [`super::damping`]
//! and [`super::tangential`] have the words, and which constants follow them.

use super::choice::Choice;
use super::parameters::{
    words_of, Constant, FactorForm, Keyword, LawParameters, Normal, ParameterError, KEYWORDS,
    LARGEST_CONSTANT,
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

    /// The word of a choice, and the constants that follow it.
    fn choice(
        &mut self,
        after: &str,
        keyword: &Keyword,
        p: &mut LawParameters,
    ) -> Result<(), ParameterError> {
        let words = (keyword.words)().join("|");
        let word = self.next(after, &words)?;
        let follow = (keyword.choose)(p, word).ok_or_else(|| {
            ParameterError(format!(
                "unknown word '{word}' after '{after}': expected {words}"
            ))
        })?;
        // The first choice has no keyword before it.
        let before = if keyword.name == KEYWORDS[0].name {
            word.to_owned()
        } else {
            format!("{} {word}", keyword.name)
        };
        let constants: Vec<&Constant> = follow.iter().map(|c| Constant::named(c)).collect();
        let symbols: Vec<&str> = constants.iter().map(|c| c.symbol).collect();
        for constant in &constants {
            *(constant.of)(p) = self.number(&before, &symbols.join(" "))?;
        }
        Ok(())
    }
}

/// The keyword that a word belongs behind, if there is one: `tangential` for `tfd`.
fn keyword_of(word: &str) -> Option<&'static str> {
    let mut with_it = KEYWORDS[1..].iter().filter(|k| (k.words)().contains(&word));
    // A word that belongs behind several of them, such as `none`, tells nothing.
    match (with_it.next(), with_it.next()) {
        (Some(keyword), None) => Some(keyword.name),
        _ => None,
    }
}

/// All that can be given, on one line: `hertz E nu | nfd E nu eta1 eta2 | ...; damping none | restitution e | ...`.
fn summary() -> String {
    let of = |keyword: &Keyword| {
        let words = (keyword.words)().into_iter().map(|word| {
            let follow = (keyword.choose)(&mut LawParameters::default(), word).unwrap_or_default();
            let symbols = follow.iter().map(|c| Constant::named(c).symbol);
            core::iter::once(word)
                .chain(symbols)
                .collect::<Vec<_>>()
                .join(" ")
        });
        words.collect::<Vec<_>>().join(" | ")
    };
    let (first, others) = KEYWORDS.split_first().expect("there is a normal law");
    let others = others.iter().map(|k| format!("; {} {}", k.name, of(k)));
    of(first) + &others.collect::<String>()
}

/// Reads the words of a law up to the first that is not one of its keywords, and checks the constants.
///
/// Returns the parameters and the number of words read. Where `conservative` is not given it is `yes`, but `no` with
/// `factors hale`; all else that is not given is that of `LawParameters::default`.
///
/// # Errors
/// A word that is missing, unknown where a choice is due, not a number, given twice, out of range, or that lacks the keyword
/// it belongs behind; the message names it. Without any word the message has all that can be given.
///
/// # Example
/// Viscoelastic grains of 10 MPa with friction (SI units):
/// ```
/// let words = ["nfd", "1e7", "0.3", "200", "200", "tangential", "tfd", "0.5", "zplane"];
/// let (parameters, read) = ellgran::force::syntax::parse(&words)?;
/// assert_eq!(read, 8); // "zplane" is no word of a law
/// assert_eq!((parameters.youngs_modulus, parameters.friction), (1e7, 0.5));
/// # Ok::<(), ellgran::force::ParameterError>(())
/// ```
pub fn parse(words: &[&str]) -> Result<(LawParameters, usize), ParameterError> {
    if words.is_empty() {
        return Err(ParameterError(format!(
            "a normal law is missing: {}",
            summary()
        )));
    }
    let mut p = LawParameters::default();
    let mut w = Words { words, position: 0 };
    w.choice("the normal law", &KEYWORDS[0], &mut p)?;
    let mut seen: Vec<&str> = Vec::new();
    while let Some(&word) = words.get(w.position) {
        let Some(keyword) = KEYWORDS[1..].iter().find(|k| k.name == word) else {
            if let Some(keyword) = keyword_of(word) {
                return Err(ParameterError(format!(
                    "unknown word '{word}': did you mean '{keyword} {word}'?"
                )));
            }
            if (KEYWORDS[0].words)().contains(&word) {
                return Err(ParameterError(format!(
                    "'{word}' after '{}': there is one normal law, and it comes first",
                    words[0]
                )));
            }
            break;
        };
        if seen.contains(&word) {
            return Err(ParameterError(format!("'{word}' is given twice")));
        }
        seen.push(word);
        w.position += 1;
        w.choice(word, keyword, &mut p)?;
    }
    if !seen.contains(&"conservative") {
        p.conservative = p.factors != FactorForm::Hale;
    }
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
///
/// # Example
/// ```
/// use ellgran::force::syntax::{parse, parse_wall_material};
/// use ellgran::force::PairLaw;
///
/// // Soft grains (10 MPa) on steel (200 GPa), and on a rigid wall.
/// let (grain, _) = parse(&["hertz", "1e7", "0.3"])?;
/// let (steel, read) = parse_wall_material(&grain, &["material", "2e11", "0.3"])?;
/// let (rigid, of_rigid) = parse_wall_material(&grain, &["material", "rigid"])?;
/// assert_eq!((read, of_rigid), (3, 2));
/// let modulus = |wall| Ok::<f64, ellgran::force::ParameterError>(PairLaw::resolve(&grain, wall)?.effective_modulus());
/// let of_grain = 1e7 / (1.0 - 0.3 * 0.3);
/// assert!((modulus(&rigid)? / of_grain - 1.0).abs() < 1e-14);
/// assert!((modulus(&steel)? / of_grain - 1.0 / (1.0 + 1e7 / 2e11)).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn parse_wall_material(
    grain: &LawParameters,
    words: &[&str],
) -> Result<(LawParameters, usize), ParameterError> {
    if words.first() != Some(&"material") {
        return Ok((*grain, 0));
    }
    let word = grain.normal.word();
    if !grain.normal.has_material() {
        return Err(ParameterError(format!(
            "'material' goes with {}: the constants of {word} are those of the contact, wall included",
            words_of(Normal::has_material)
        )));
    }
    let follow = grain.normal.constants().iter();
    let constants: Vec<&Constant> = follow.map(|name| Constant::named(name)).collect();
    let symbols: Vec<&str> = constants.iter().map(|c| c.symbol).collect();
    let law = &format!("material' with '{word}");
    let what = &format!("{}, or by rigid", symbols.join(" "));
    let mut w = Words { words, position: 1 };
    let mut wall = *grain;
    if words.get(1) == Some(&"rigid") {
        w.position += 1;
        wall.youngs_modulus = LARGEST_CONSTANT;
        (wall.shear_viscosity, wall.bulk_viscosity) = (0.0, 0.0);
        return Ok((wall, w.position));
    }
    for constant in constants {
        *(constant.of)(&mut wall) = w.number(law, what)?;
    }
    wall.validate()
        .map_err(|e| ParameterError(format!("material of the wall: {e}")))?;
    Ok((wall, w.position))
}

#[cfg(test)]
mod tests {
    use super::parse;

    /// What lacks is named with the keyword that it belongs behind, which the normal law has not.
    #[test]
    fn messages_name_the_place() {
        for (deck, says) in [
            ("hertz 1e7 0.3 tfd 0.5", "did you mean 'tangential tfd'?"),
            ("hertz 1e7 0.3 hale", "did you mean 'factors hale'?"),
            ("nfd 1e7 0.3", "'nfd'"),
            ("hertz 1e7 0.3 tangential tfd", "'tangential tfd'"),
        ] {
            let words: Vec<&str> = deck.split(' ').collect();
            let message = parse(&words).unwrap_err().to_string();
            assert!(message.contains(says), "{deck}: {message}");
        }
    }
}
