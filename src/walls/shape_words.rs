// SPDX-License-Identifier: MIT OR Apache-2.0
//! The words of a deck that describe a shape of a wall.

/// What follows the word `shape`.
///
/// # Example
/// ```
/// assert!(ellgran::walls::SHAPE_SYNTAX.starts_with("shape NAME [point x y z]"));
/// ```
pub const SHAPE_SYNTAX: &str =
    "shape NAME [point x y z] [axis ax ay az] [radius r] [radii r1 r2] [bounds lo hi] \
     [ends none|open|closed none|open|closed] [side inside|outside|centre]";

/// Places of the words of `side` and `ends` among their choices.
const SIDES: [&str; 3] = ["centre", "inside", "outside"];
const ENDS: [&str; 3] = ["none", "open", "closed"];

/// The words of a shape of this name; all where there is none, which is told of where the shape is made.
pub(super) fn words_of(name: &str) -> &'static [&'static str] {
    match name {
        "plane" => &["point", "axis", "side"],
        "sphere" => &["point", "radius", "side"],
        "cylinder" => &["point", "axis", "radius", "bounds", "ends", "side"],
        "cone" => &["point", "axis", "radii", "bounds", "ends", "side"],
        _ => &["point", "axis", "radius", "radii", "bounds", "ends", "side"],
    }
}

/// A shape as a deck describes it; what is not given is as in `Default`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeWords<'w> {
    /// Its name, any word.
    pub name: &'w str,
    /// `point`.
    pub point: [f64; 3],
    /// `axis`; z where it is not given.
    pub axis: [f64; 3],
    /// `radius`, the first, or `radii`.
    pub radii: [f64; 2],
    /// `bounds`; both 0 where they are not given.
    pub bounds: [f64; 2],
    /// `ends`: 0 for none, 1 open, 2 closed.
    pub ends: [i32; 2],
    /// `side`: 0 for that of a particle's centre, 1 inside, 2 outside.
    pub side: i32,
}

/// Words, and how many have been read.
struct Words<'w> {
    words: &'w [&'w str],
    read: usize,
}

impl<'w> Words<'w> {
    /// The values of a keyword, which has been read.
    fn values<const N: usize>(
        &mut self,
        keyword: &str,
        name: &str,
    ) -> Result<[&'w str; N], String> {
        let values = self.words[self.read..].first_chunk();
        self.read += N;
        values.copied().ok_or_else(|| {
            let s = if N == 1 { "" } else { "s" };
            format!("'{keyword}' of shape {name} needs {N} value{s}: {SHAPE_SYNTAX}")
        })
    }

    fn numbers<const N: usize>(&mut self, keyword: &str, name: &str) -> Result<[f64; N], String> {
        let mut numbers = [0.0; N];
        let words = self.values::<N>(keyword, name)?;
        for (number, word) in numbers.iter_mut().zip(words) {
            *number = word
                .parse()
                .map_err(|_| format!("'{keyword}' of shape {name}: '{word}' is not a number"))?;
        }
        Ok(numbers)
    }

    fn choices<const N: usize>(
        &mut self,
        keyword: &str,
        name: &str,
        of: &[&str],
    ) -> Result<[i32; N], String> {
        let mut chosen = [0; N];
        let words = self.values::<N>(keyword, name)?;
        for (number, word) in chosen.iter_mut().zip(words) {
            let place = of.iter().position(|choice| *choice == word);
            *number = place.ok_or_else(|| {
                let all = of.join(", ");
                format!("'{keyword}' of shape {name} is one of {all}, not '{word}'")
            })? as i32;
        }
        Ok(chosen)
    }
}

impl<'w> ShapeWords<'w> {
    /// Reads the words that follow `shape`, up to the first that is none of a shape's; with them how many were read. Ranges are checked
    /// where the shape is made.
    ///
    /// # Errors
    /// A word that is missing, given twice, not of this shape, not a number or not one of its choices.
    ///
    /// # Example
    /// ```
    /// let words = ["cone", "radii", "0.4", "2.2", "bounds", "-2", "4", "side", "inside", "shear"];
    /// let (shape, read) = ellgran::walls::ShapeWords::read(&words).unwrap();
    /// assert_eq!((shape.name, shape.radii, shape.side, read), ("cone", [0.4, 2.2], 1, 9));
    /// ```
    pub fn read(words: &'w [&'w str]) -> Result<(Self, usize), String> {
        let Some(name) = words.first() else {
            return Err(format!("'shape' needs a name: {SHAPE_SYNTAX}"));
        };
        let mut shape = ShapeWords {
            name,
            point: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            radii: [0.0; 2],
            bounds: [0.0; 2],
            ends: [0; 2],
            side: 0,
        };
        let mut w = Words { words, read: 1 };
        let mut given: Vec<&str> = vec![];
        while let Some(&keyword) = words.get(w.read) {
            let before = w.read;
            w.read += 1;
            match keyword {
                "point" => shape.point = w.numbers(keyword, name)?,
                "axis" => shape.axis = w.numbers(keyword, name)?,
                "radius" => [shape.radii[0]] = w.numbers(keyword, name)?,
                "radii" => shape.radii = w.numbers(keyword, name)?,
                "bounds" => shape.bounds = w.numbers(keyword, name)?,
                "ends" => shape.ends = w.choices(keyword, name, &ENDS)?,
                "side" => [shape.side] = w.choices(keyword, name, &SIDES)?,
                _ => return Ok((shape, before)),
            }
            if !words_of(name).contains(&keyword) {
                let of_it = words_of(name).join(", ");
                return Err(format!("shape {name} has no '{keyword}', but {of_it}"));
            }
            if given.contains(&keyword) {
                return Err(format!("'{keyword}' of shape {name} is given twice"));
            }
            given.push(keyword);
        }
        Ok((shape, w.read))
    }
}
