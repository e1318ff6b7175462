// SPDX-License-Identifier: MIT OR Apache-2.0
//! Laws: parameters, the words of a deck, and the table of all pairs of types.

use super::growing::{given, growing, GivenArray, Output};
use super::status::{
    at_border, required, required_mut, slice, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT,
    ELLGRAN_ERROR_LAW, ELLGRAN_ERROR_TEXT,
};
use crate::contact::Laws;
use crate::force::parameters::with_parameters;
use crate::force::syntax;
use crate::force::{Choice, LawParameters, ParameterError};
use core::ffi::c_char;
use std::ffi::CStr;
use std::sync::atomic::{AtomicU64, Ordering};

pub use crate::force::damping::numbers::*;
pub use crate::force::parameters::numbers::*;
pub use crate::force::rolling::numbers::*;
pub use crate::force::tangential::numbers::*;
pub use crate::force::twisting::numbers::*;

/// Option of `ellgran_laws_new`: no cached normal in the history. For scenes of spheres alone, which lose nothing;
/// ellipsoids then search anew every step, and where their normal turns friction and what resists rolling and twisting have
/// an error of the order of the time step.
pub const ELLGRAN_OPTION_NO_WARM_START: u32 = 1;

/// The struct of the table of parameters: its size, the choices by their numbers, the switches, the constants.
macro_rules! law_parameters {
    (
        $(#[$about:meta])*
        choices { $( $(#[$choice_doc:meta])* $choice:ident: $type:ident = $default:ident; )+ }
        switches { $( $(#[$switch_doc:meta])* $switch:ident = $on:literal; )+ }
        constants { $( $(#[$doc:meta])* $constant:ident = $($column:tt),+; )+ }
        later_choices {
            $( $(#[$later_choice_doc:meta])* $later_choice:ident: $later_type:ident = $later_default:ident; )+
        }
        later_constants { $( $(#[$later_doc:meta])* $later:ident = $($later_column:tt),+; )+ }
        latest_choices {
            $( $(#[$latest_choice_doc:meta])* $latest_choice:ident: $latest_type:ident = $latest_default:ident; )+
        }
    ) => {
        $(#[$about])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug)]
        pub struct EllgranLawParameters {
            /// `sizeof(EllgranLawParameters)`; `ELLGRAN_INIT` sets it.
            pub size: usize,
            $( $(#[$choice_doc])* pub $choice: i32, )+
            $( $(#[$switch_doc])* pub $switch: i32, )+
            $( $(#[$doc])* pub $constant: f64, )+
            $( $(#[$later_choice_doc])* pub $later_choice: i32, )+
            $( $(#[$later_doc])* pub $later: f64, )+
            $( $(#[$latest_choice_doc])* pub $latest_choice: i32, )+
            /// Not used; 0.
            pub reserved: i32,
        }

        impl From<&LawParameters> for EllgranLawParameters {
            fn from(p: &LawParameters) -> Self {
                EllgranLawParameters {
                    size: size_of::<EllgranLawParameters>(),
                    $( $choice: p.$choice.number(), )+
                    $( $switch: p.$switch as i32, )+
                    $( $constant: p.$constant, )+
                    $( $later_choice: p.$later_choice.number(), )+
                    $( $later: p.$later, )+
                    $( $latest_choice: p.$latest_choice.number(), )+
                    reserved: 0,
                }
            }
        }

        impl EllgranLawParameters {
            pub(super) fn to_core(self) -> Result<LawParameters, Failure> {
                Ok(LawParameters {
                    $( $choice: chosen(stringify!($choice), self.$choice)?, )+
                    $( $switch: switched(stringify!($switch), self.$switch)?, )+
                    $( $constant: self.$constant, )+
                    $( $later_choice: chosen(stringify!($later_choice), self.$later_choice)?, )+
                    $( $later: self.$later, )+
                    $( $latest_choice: chosen(stringify!($latest_choice), self.$latest_choice)?, )+
                })
            }
        }
    };
}
with_parameters!(law_parameters);

growing!(EllgranLawParameters, tangential_damping);

/// The laws between all types of a scene. Opaque, immutable.
pub struct EllgranLaws {
    pub(super) laws: Laws,
    /// No other laws of this process have it, those at the same address before or after neither.
    pub(super) number: u64,
}

impl EllgranLaws {
    /// The table. Public for the border of `gpu/driver`; no interface for others.
    #[doc(hidden)]
    pub fn table(&self) -> &Laws {
        &self.laws
    }

    fn new(laws: Laws) -> Box<EllgranLaws> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        Box::new(EllgranLaws { laws, number })
    }
}

fn unknown(name: &str, value: i32) -> Failure {
    Failure::new(
        ELLGRAN_ERROR_ARGUMENT,
        format!("{name} = {value} is none of its constants"),
    )
}

/// The choice with this number.
fn chosen<C: Choice>(name: &str, value: i32) -> Result<C, Failure> {
    C::of_number(value).ok_or_else(|| unknown(name, value))
}

fn switched(name: &str, value: i32) -> Result<bool, Failure> {
    match value {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(unknown(name, value)),
    }
}

fn law_failure(e: ParameterError) -> Failure {
    Failure::new(ELLGRAN_ERROR_LAW, e.0)
}

/// Writes the defaults: elastic, frictionless, conservative, no attraction, exact factors, displacement rescaled; all constants
/// zero.
///
/// # Safety
/// `parameters` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_law_parameters_default(
    parameters: *mut EllgranLawParameters,
) -> i32 {
    at_border("ellgran_law_parameters_default", || {
        // SAFETY: promised by the caller.
        let mut out = unsafe { Output::new(parameters, "parameters") }?;
        out.write(&EllgranLawParameters::from(&LawParameters::default()));
        Ok(())
    })
}

/// Reads the words of a deck that choose a law (what follows `I J` in LAMMPS' `pair_coeff`) and checks the constants.
///
/// The normal law comes first, with its constants; then in any order a keyword with its word and the constants of that, such as
/// `nfd 3e6 0.3 200 200 tangential tfd 0.5`. Without any word the message of the error has all that can be given.
///
/// With `consumed` not NULL, reading ends at the first word that is none of these, and the number of words read is
/// written; with NULL such a word is an error.
///
/// # Safety
/// `words` points to `word_count` strings that end with NUL; `consumed` and `parameters` are NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_law_parameters_parse(
    word_count: usize,
    words: *const *const c_char,
    consumed: *mut usize,
    parameters: *mut EllgranLawParameters,
) -> i32 {
    at_border("ellgran_law_parameters_parse", || {
        // SAFETY: promised by the caller.
        let texts = unsafe { given_words(words, word_count) }?;
        // SAFETY: promised by the caller.
        let mut out = unsafe { Output::new(parameters, "parameters") }?;
        let (p, read) = syntax::parse(&texts).map_err(law_failure)?;
        // SAFETY: promised by the caller.
        match unsafe { consumed.as_mut() } {
            Some(consumed) => *consumed = read,
            None if read < texts.len() => {
                return Err(Failure::new(
                    ELLGRAN_ERROR_LAW,
                    format!("unknown word '{}'", texts[read]),
                ))
            }
            None => {}
        }
        out.write(&EllgranLawParameters::from(&p));
        Ok(())
    })
}

/// Reads the material of a wall: `material E nu` with the law `hertz`, `material E nu eta1 eta2` with `nfd`, `material rigid` with
/// either, from the first word on.
///
/// `wall` becomes the wall's side of the contact with grains of the law `grain`: for `ellgran_laws_new` the parameters of a type of its
/// own, which is mixed with the grain's where the pair of the two is not set. The number of words read goes to `consumed`. Where the
/// first word is another one, `wall` becomes `grain`, and no word is read.
///
/// # Safety
/// `words` points to `word_count` strings that end with NUL; the other pointers are NULL or valid, `consumed` and `wall` for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_material_parse(
    grain: *const EllgranLawParameters,
    word_count: usize,
    words: *const *const c_char,
    consumed: *mut usize,
    wall: *mut EllgranLawParameters,
) -> i32 {
    at_border("ellgran_wall_material_parse", || {
        // SAFETY: promised by the caller, for all of this function.
        let grain = unsafe { given(grain, "grain") }?.to_core()?;
        // SAFETY: `words` is NULL or has `word_count` pointers to texts that end with NUL, by this function's safety section.
        let texts = unsafe { given_words(words, word_count) }?;
        // SAFETY: `consumed` is NULL or valid for writes, by this function's safety section.
        let consumed = unsafe { required_mut(consumed, "consumed") }?;
        // SAFETY: `wall` is NULL or valid for writes of its `size` bytes, by this function's safety section.
        let mut out = unsafe { Output::new(wall, "wall") }?;
        let (p, read) = syntax::parse_wall_material(&grain, &texts).map_err(law_failure)?;
        *consumed = read;
        out.write(&EllgranLawParameters::from(&p));
        Ok(())
    })
}

/// # Safety
/// `words` points to `word_count` strings that end with NUL, for the lifetime that the caller gives them.
pub(super) unsafe fn given_words<'a>(
    words: *const *const c_char,
    word_count: usize,
) -> Result<Vec<&'a str>, Failure> {
    // SAFETY: promised by the caller.
    let pointers = unsafe { slice(words, word_count, "words") }?;
    let mut texts = Vec::with_capacity(word_count);
    for (k, &pointer) in pointers.iter().enumerate() {
        // SAFETY: promised by the caller; checked for NULL.
        unsafe { required(pointer, &format!("words[{k}]")) }?;
        // SAFETY: as above, and the text ends with NUL.
        let text = unsafe { CStr::from_ptr(pointer) };
        texts.push(
            text.to_str().map_err(|_| {
                Failure::new(ELLGRAN_ERROR_TEXT, format!("words[{k}] is not UTF-8"))
            })?,
        );
    }
    Ok(texts)
}

/// Builds the laws of a scene with `type_count` types, counted from 1.
///
/// `parameters` and `is_set` are `type_count` x `type_count`, row by row; the first entry of `parameters` has its size even
/// where it is not set. A pair may be set as I J or as J I. A pair that
/// is not set is mixed from I I and J J: moduli in series, relaxation times by compliance, friction and restitution by
/// geometric mean; laws of different kinds cannot be mixed.
///
/// `options`: 0 or ELLGRAN_OPTION_NO_WARM_START.
///
/// # Safety
/// The arrays have the lengths above; `laws` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_laws_new(
    type_count: i32,
    parameters: *const EllgranLawParameters,
    is_set: *const u8,
    options: u32,
    laws: *mut *mut EllgranLaws,
) -> i32 {
    at_border("ellgran_laws_new", || {
        let types = usize::try_from(type_count)
            .ok()
            .filter(|t| *t > 0 && *t < 10_000)
            .ok_or_else(|| {
                Failure::new(
                    ELLGRAN_ERROR_ARGUMENT,
                    format!("type_count = {type_count} must be between 1 and 9999"),
                )
            })?;
        if options & !ELLGRAN_OPTION_NO_WARM_START != 0 {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("options = {options} has unknown bits"),
            ));
        }
        // SAFETY: promised by the caller.
        let given = unsafe { GivenArray::new(parameters, types * types, "parameters") }?;
        // SAFETY: promised by the caller.
        let set = unsafe { slice(is_set, types * types, "is_set") }?;
        // SAFETY: promised by the caller.
        let out = unsafe { required_mut(laws, "laws") }?;
        let mut table = Vec::with_capacity(types * types);
        for (k, s) in set.iter().enumerate() {
            table.push(if *s != 0 {
                Some(given.get(k)?.to_core()?)
            } else {
                None
            });
        }
        let warm = options & ELLGRAN_OPTION_NO_WARM_START == 0;
        let built = Laws::new(types, &table, warm).map_err(law_failure)?;
        *out = Box::into_raw(EllgranLaws::new(built));
        Ok(())
    })
}

/// The same laws with other coefficients of friction: for engines that give friction per pair of types and all else per
/// type. `friction` has `type_count` x `type_count` entries, row by row. A pair with 0 has no tangential law; one that had
/// none keeps none. The history keeps its length. To be freed like the other.
///
/// # Safety
/// `laws` is NULL or valid; `friction` has the length above; `result` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_laws_with_friction(
    laws: *const EllgranLaws,
    friction: *const f64,
    result: *mut *mut EllgranLaws,
) -> i32 {
    at_border("ellgran_laws_with_friction", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `friction` is NULL or has one entry for each pair of types, by this function's safety section.
        let friction = unsafe { slice(friction, laws.types() * laws.types(), "friction") }?;
        // SAFETY: `result` is NULL or valid for writes, by this function's safety section.
        let out = unsafe { required_mut(result, "result") }?;
        let built = laws.with_friction(friction).map_err(law_failure)?;
        *out = Box::into_raw(EllgranLaws::new(built));
        Ok(())
    })
}

/// The same laws with other coefficients of restitution: for engines that give restitution per pair of types and all else
/// per type. `restitution` has `type_count` x `type_count` entries, row by row, each above 0 and at most 1; every law must have
/// ELLGRAN_DAMPING_RESTITUTION. To be freed like the other.
///
/// # Safety
/// `laws` is NULL or valid; `restitution` has the length above; `result` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_laws_with_restitution(
    laws: *const EllgranLaws,
    restitution: *const f64,
    result: *mut *mut EllgranLaws,
) -> i32 {
    at_border("ellgran_laws_with_restitution", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        let restitution =
            // SAFETY: `restitution` is NULL or has one entry for each pair of types, by this function's safety section.
            unsafe { slice(restitution, laws.types() * laws.types(), "restitution") }?;
        // SAFETY: `result` is NULL or valid for writes, by this function's safety section.
        let out = unsafe { required_mut(result, "result") }?;
        let built = laws.with_restitution(restitution).map_err(law_failure)?;
        *out = Box::into_raw(EllgranLaws::new(built));
        Ok(())
    })
}

/// What the contact of two types has, as their materials mix.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranMixture {
    /// `sizeof(EllgranMixture)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// E*, pressure: `1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j`; 0 for a law without a material.
    pub effective_modulus: f64,
    /// G*, pressure: `1/G* = (2 - nu_i)/G_i + (2 - nu_j)/G_j`; 0 for a law without a material.
    pub effective_shear_modulus: f64,
    /// A_n, time: the ratio of normal dashpot and spring while the bodies approach; 0 where there is none, as with damping by a
    /// coefficient of restitution and for a law without a material.
    pub normal_relaxation_time: f64,
    /// A_t of a circular contact, time: the ratio of tangential dashpot and spring without slip; 0 without a tangential law that
    /// takes its stiffness from the material.
    pub tangential_relaxation_time: f64,
    /// Share of the body of the first type in the penetration, by compliance; 0.5 for a law without a material.
    pub share_i: f64,
}

growing!(EllgranMixture);

/// Moduli, relaxation times and the share in the penetration of a pair of types.
///
/// # Safety
/// `laws` is NULL or valid; `mixture` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_laws_mixture(
    laws: *const EllgranLaws,
    type_i: i32,
    type_j: i32,
    mixture: *mut EllgranMixture,
) -> i32 {
    at_border("ellgran_laws_mixture", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `mixture` is NULL or valid for writes of its `size` bytes, by this function's safety section.
        let mut out = unsafe { Output::new(mixture, "mixture") }?;
        let law = laws.get(
            check_type(laws, type_i, "type_i")?,
            check_type(laws, type_j, "type_j")?,
        );
        out.write(&EllgranMixture {
            size: size_of::<EllgranMixture>(),
            effective_modulus: law.effective_modulus(),
            effective_shear_modulus: law.effective_shear_modulus(),
            normal_relaxation_time: law.normal_relaxation_time(),
            tangential_relaxation_time: law.tangential_relaxation_time(),
            share_i: law.constants.share_i,
        });
        Ok(())
    })
}

/// Whether some law can create energy while nothing in it dissipates any: `displacement total` or `incremental` of `tfd` or
/// `mindlin`, without viscosity or damping. Writes the first such pair of types, or twice 0.
///
/// # Safety
/// `laws` is NULL or valid; `type_i` and `type_j` are NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_laws_create_energy(
    laws: *const EllgranLaws,
    type_i: *mut i32,
    type_j: *mut i32,
) -> i32 {
    at_border("ellgran_laws_create_energy", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `type_i` is NULL or valid for writes, by this function's safety section.
        let out_i = unsafe { required_mut(type_i, "type_i") }?;
        // SAFETY: `type_j` is NULL or valid for writes, by this function's safety section.
        let out_j = unsafe { required_mut(type_j, "type_j") }?;
        let (i, j) = laws.creates_energy().unwrap_or((0, 0));
        (*out_i, *out_j) = (i as i32, j as i32);
        Ok(())
    })
}

/// Frees laws; NULL is allowed.
///
/// # Safety
/// `laws` is NULL or came from `ellgran_laws_new` and is not used again.
#[no_mangle]
pub unsafe extern "C" fn ellgran_laws_free(laws: *mut EllgranLaws) {
    if !laws.is_null() {
        // SAFETY: promised by the caller.
        drop(unsafe { Box::from_raw(laws) });
    }
}

/// Doubles of history per contact, possibly 0; -1 for NULL. All zeros is a contact of which nothing is remembered.
///
/// # Safety
/// `laws` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_laws_history_length(laws: *const EllgranLaws) -> i32 {
    // SAFETY: promised by the caller.
    unsafe { laws.as_ref() }.map_or(-1, |l| l.laws.layout().length as i32)
}

/// Where in a contact's history the tangential memory (3 doubles, world frame) stands; -1 for NULL and without friction, unless something
/// resists rolling or twisting.
/// It is the displacement xi with `displacement total`, the force of all springs with `displacement hysteretic`, else the force
/// that there would be without slip.
///
/// # Safety
/// `laws` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_laws_memory_offset(laws: *const EllgranLaws) -> i32 {
    // SAFETY: promised by the caller.
    unsafe { laws.as_ref() }
        .and_then(|l| l.laws.layout().memory)
        .map_or(-1, |at| at as i32)
}

/// 1 if what contacts remember under the laws `before` means the same under `laws`, 0 if it stands in other places of the history, which may
/// be as long all the same, or is a displacement under one of them and a force under the other: set it to 0 then. -1 for NULL.
///
/// # Safety
/// `laws` and `before` are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_laws_read_histories_of(
    laws: *const EllgranLaws,
    before: *const EllgranLaws,
) -> i32 {
    // SAFETY: promised by the caller.
    match unsafe { (laws.as_ref(), before.as_ref()) } {
        (Some(laws), Some(before)) => laws.laws.read_histories_of(&before.laws) as i32,
        _ => -1,
    }
}

/// 1 if any law reads contact masses (damping by restitution), else 0; -1 for NULL.
///
/// # Safety
/// `laws` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_laws_uses_mass(laws: *const EllgranLaws) -> i32 {
    // SAFETY: promised by the caller.
    unsafe { laws.as_ref() }.map_or(-1, |l| l.laws.features().mass as i32)
}

/// Writes to `target` the history of the contact (j, i) from that of (i, j), `ellgran_laws_history_length` doubles.
///
/// # Safety
/// `laws` is NULL or valid; `source` and `target` are NULL or have that many doubles and do not overlap.
#[no_mangle]
pub unsafe extern "C" fn ellgran_history_swap(
    laws: *const EllgranLaws,
    source: *const f64,
    target: *mut f64,
) -> i32 {
    at_border("ellgran_history_swap", || {
        // SAFETY: promised by the caller.
        let layout = unsafe { required(laws, "laws") }?.laws.layout();
        // SAFETY: promised by the caller.
        let source = unsafe { slice(source, layout.length, "source") }?;
        // SAFETY: promised by the caller.
        let target = unsafe { slice_mut(target, layout.length, "target") }?;
        layout.swap(source, target);
        Ok(())
    })
}

/// Writes a line that describes the resolved law of two types: its kernel and constants. The text ends with NUL and is
/// cut to `capacity` bytes.
///
/// # Safety
/// `laws` is NULL or valid; `buffer` is NULL or has `capacity` bytes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_laws_describe(
    laws: *const EllgranLaws,
    type_i: i32,
    type_j: i32,
    buffer: *mut c_char,
    capacity: usize,
) -> i32 {
    at_border("ellgran_laws_describe", || {
        // SAFETY: promised by the caller.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        let (i, j) = (
            check_type(laws, type_i, "type_i")?,
            check_type(laws, type_j, "type_j")?,
        );
        // SAFETY: promised by the caller.
        let out = unsafe { slice_mut(buffer.cast::<u8>(), capacity, "buffer") }?;
        let law = laws.get(i, j);
        let text = law.describe();
        let end = text.len().min(capacity.saturating_sub(1));
        if capacity > 0 {
            out[..end].copy_from_slice(&text.as_bytes()[..end]);
            out[end] = 0;
        }
        Ok(())
    })
}

/// A type in range.
pub(super) fn check_type(laws: &Laws, value: i32, name: &str) -> Result<usize, Failure> {
    usize::try_from(value)
        .ok()
        .filter(|t| *t >= 1 && *t <= laws.types())
        .ok_or_else(|| {
            Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("{name} = {value} is not between 1 and {}", laws.types()),
            )
        })
}
