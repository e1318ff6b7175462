// SPDX-License-Identifier: MIT OR Apache-2.0
//! A choice among laws or forms: one table gives the Rust value, the word of the decks, the number of the C interface and
//! the constants that follow the word.

/// One of the values that a keyword can have.
///
/// # Example
/// ```
/// use ellgran::force::{Choice, Normal};
///
/// // The laws of a deck, with the constants that follow each word.
/// let words: Vec<&str> = Normal::ALL.iter().map(|normal| normal.word()).collect();
/// assert_eq!(words, ["hertz", "nfd", "lsd"]);
/// assert_eq!(Normal::Hertz.constants(), ["youngs_modulus", "poissons_ratio"]);
/// assert_eq!(Normal::of_word("nfd"), Some(Normal::Nfd));
/// assert_eq!(Normal::of_number(Normal::Lsd.number()), Some(Normal::Lsd));
/// ```
pub trait Choice: Copy + 'static {
    /// All values.
    const ALL: &'static [Self];
    /// The word of the decks.
    fn word(self) -> &'static str;
    /// The constants that follow the word in a deck, in this order: names of fields of
    /// [`LawParameters`](super::parameters::LawParameters).
    fn constants(self) -> &'static [&'static str];
    /// The number that stands for it in the C interface.
    fn number(self) -> i32;

    /// The value with this word.
    fn of_word(word: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|c| c.word() == word)
    }

    /// The value with this number.
    fn of_number(number: i32) -> Option<Self> {
        Self::ALL.iter().copied().find(|c| c.number() == number)
    }
}

/// Enumerations of choices, and a module `numbers` of their constants in the C interface. A row is
/// `Variant = number, "word", C_CONSTANT, [constants that follow the word];`. `cargo xtask header` reads these tables too: the
/// comment of a row becomes that of the C constant.
macro_rules! choices {
    ($(
        $(#[$about:meta])*
        $name:ident {
            $( $(#[$row:meta])* $variant:ident = $number:literal, $word:literal, $constant:ident, [$($follows:ident),*]; )+
        }
    )+) => {
        $(
            $(#[$about])*
            #[derive(Clone, Copy, Debug, PartialEq, Eq)]
            #[repr(i32)]
            pub enum $name {
                $( $(#[$row])* $variant = $number, )+
            }

            impl crate::force::choice::Choice for $name {
                const ALL: &'static [Self] = &[$($name::$variant),+];
                fn word(self) -> &'static str {
                    match self { $($name::$variant => $word),+ }
                }
                fn constants(self) -> &'static [&'static str] {
                    match self { $($name::$variant => &[$(stringify!($follows)),*]),+ }
                }
                fn number(self) -> i32 {
                    self as i32
                }
            }
        )+

        /// The numbers of the C interface.
        pub mod numbers {
            $( $( $(#[$row])* pub const $constant: i32 = $number; )+ )+
        }
    };
}
pub(crate) use choices;

/// Constants of a resolved law, and a macro that hands the names of the fields to another one: the lanes load them field by
/// field. The first token is a dollar sign.
macro_rules! resolved_constants {
    ($d:tt $(#[$about:meta])* $name:ident, $each:ident { $( $(#[$doc:meta])* $field:ident, )+ }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug)]
        #[repr(C)]
        pub struct $name<T = f64> {
            $( $(#[$doc])* pub $field: T, )+
        }

        /// Calls a macro with these arguments, the name of the struct and those of its fields.
        macro_rules! $each {
            ($d macro:ident, $d($d argument:tt)*) => { $d macro!($d($d argument)* $name, $($field),+) };
        }
        pub(crate) use $each;
    };
}
pub(crate) use resolved_constants;
