// SPDX-License-Identifier: MIT OR Apache-2.0
//! How does one text hold all mutants of a file? Each place that has mutants becomes a `match` over which of them is on.
//!
//! Operands are evaluated once, before the choice, so that places within places do not multiply the text. What only a compiler
//! evaluates (constants, lengths, patterns) cannot be switched.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::ops::Range;

use anyhow::{Context, Result};
use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use super::list::{Genre, Mutant, Position};

/// A place that has mutants.
#[derive(Debug)]
pub struct Place {
    /// Its mutants; the first is choice 1.
    pub mutants: Vec<usize>,
    /// What is written anew, in bytes of the file.
    range: Range<usize>,
    form: Form,
}

type Bytes = Range<usize>;

#[derive(Debug)]
enum Form {
    /// Both operands are moved.
    Arithmetic {
        left: Bytes,
        operator: String,
        right: Bytes,
    },
    /// Both operands are lent.
    Comparison {
        left: Bytes,
        operator: String,
        right: Bytes,
    },
    /// The operand on the right may not be evaluated.
    Lazy {
        left: Bytes,
        and: bool,
        right: Bytes,
    },
    Assignment {
        left: Bytes,
        operator: String,
        right: Bytes,
    },
    Unary {
        operator: String,
        operand: Bytes,
    },
    /// Behind the brace that opens a function.
    Body,
    Guard,
    /// Behind the pattern, or the guard that there is.
    Arm {
        guarded: bool,
    },
    Field {
        name: String,
        rest: Bytes,
    },
}

/// A file and its places.
pub struct Schemata<'a> {
    text: &'a str,
    places: Vec<Place>,
    mutants: &'a [Mutant],
}

/// In the rewritten text, in front of what is a mutant's own or the original's; to the end of its line.
const MUTANT: &str = "/*mutant ";
const PLACE: &str = "/*place ";

/// To whom a line of a rewritten text belongs.
#[derive(Debug, PartialEq, Eq)]
pub enum Owner {
    Mutant(usize),
    Place(usize),
}

/// Whose a line is.
pub fn owner(line: &str) -> Option<Owner> {
    let number = |mark: &str| {
        let (number, _) = line.trim_start().strip_prefix(mark)?.split_once("*/")?;
        number.parse().ok()
    };
    let mutant = number(MUTANT).map(Owner::Mutant);
    mutant.or_else(|| number(PLACE).map(Owner::Place))
}

impl<'a> Schemata<'a> {
    /// Finds the places of those mutants, indices into `all`, that are in this text.
    pub fn find(text: &'a str, all: &'a [Mutant], of_file: &[usize]) -> Result<Self> {
        let tree = syn::parse_file(text)?;
        let mut asked = BTreeMap::<_, Vec<usize>>::new();
        for &index in of_file {
            let mutant = &all[index];
            asked
                .entry((mutant.genre, mutant.start))
                .or_default()
                .push(index);
        }
        let mut finder = Finder {
            asked,
            places: Vec::new(),
        };
        finder.visit_file(&tree);
        let mut places = finder.places;
        // What is around comes before what is within: the order of the visit where both begin at one byte.
        places.sort_by_key(|place| (place.range.start, std::cmp::Reverse(place.range.end)));
        Ok(Schemata {
            text,
            places,
            mutants: all,
        })
    }

    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// The text with all mutants but those left out; the first place has this number.
    pub fn write(&self, first: usize, left_out: &BTreeSet<usize>) -> String {
        let writer = Writer {
            schemata: self,
            first,
            left_out,
        };
        writer.range(0..self.text.len(), 0)
    }
}

/// One mutant alone, without a switch.
pub fn changed(text: &str, mutant: &Mutant) -> Result<String> {
    let (start, end) = (offset(text, mutant.start)?, offset(text, mutant.end)?);
    Ok(format!(
        "{}{}{}",
        &text[..start],
        mutant.replacement,
        &text[end..]
    ))
}

fn offset(text: &str, position: Position) -> Result<usize> {
    let mut lines = text.split_inclusive('\n');
    let before: usize = lines.by_ref().take(position.line - 1).map(str::len).sum();
    let line = text[before..].split('\n').next().context("no such line")?;
    let mut within = line.char_indices().map(|(at, _)| at).chain([line.len()]);
    let within = within.nth(position.column - 1);
    Ok(before + within.context("no such column")?)
}

/// Searches the tree for what has mutants.
struct Finder {
    /// What has not been found.
    asked: BTreeMap<(Genre, Position), Vec<usize>>,
    places: Vec<Place>,
}

impl Finder {
    fn place(&mut self, genre: Genre, named_at: Span, range: Bytes, form: Form) {
        let start = named_at.start();
        let position = Position {
            line: start.line,
            column: start.column + 1,
        };
        if let Some(mutants) = self.asked.remove(&(genre, position)) {
            self.places.push(Place {
                mutants,
                range,
                form,
            });
        }
    }

    fn body(&mut self, signature: &syn::Signature, block: &syn::Block) {
        // A function that returns `impl Trait` has one type of result.
        if matches!(&signature.output, syn::ReturnType::Type(_, of) if matches!(**of, syn::Type::ImplTrait(_)))
        {
            return;
        }
        if let Some(first) = block.stmts.first() {
            let behind = block.brace_token.span.open().byte_range().end;
            let span = first.span();
            self.place(Genre::FunctionValue, span, behind..behind, Form::Body);
        }
    }
}

fn bytes(of: &impl Spanned) -> Bytes {
    of.span().byte_range()
}

impl<'ast> Visit<'ast> for Finder {
    fn visit_item_const(&mut self, _: &'ast syn::ItemConst) {}
    fn visit_item_static(&mut self, _: &'ast syn::ItemStatic) {}
    fn visit_impl_item_const(&mut self, _: &'ast syn::ImplItemConst) {}
    fn visit_trait_item_const(&mut self, _: &'ast syn::TraitItemConst) {}
    fn visit_expr_const(&mut self, _: &'ast syn::ExprConst) {}
    fn visit_type(&mut self, _: &'ast syn::Type) {}
    fn visit_generic_argument(&mut self, _: &'ast syn::GenericArgument) {}
    fn visit_item_enum(&mut self, _: &'ast syn::ItemEnum) {}
    fn visit_pat(&mut self, _: &'ast syn::Pat) {}

    fn visit_expr_repeat(&mut self, repeat: &'ast syn::ExprRepeat) {
        self.visit_expr(&repeat.expr);
    }

    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        if function.sig.constness.is_none() {
            self.body(&function.sig, &function.block);
            visit::visit_item_fn(self, function);
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        if function.sig.constness.is_none() {
            self.body(&function.sig, &function.block);
            visit::visit_impl_item_fn(self, function);
        }
    }

    fn visit_trait_item_fn(&mut self, function: &'ast syn::TraitItemFn) {
        if let Some(block) = &function.default {
            self.body(&function.sig, block);
        }
        visit::visit_trait_item_fn(self, function);
    }

    fn visit_expr_binary(&mut self, binary: &'ast syn::ExprBinary) {
        use syn::BinOp::*;
        let operator = binary.op.span().source_text().unwrap_or_default();
        let (left, right) = (bytes(&binary.left), bytes(&binary.right));
        let form = match binary.op {
            And(_) | Or(_) => Form::Lazy {
                left,
                and: matches!(binary.op, And(_)),
                right,
            },
            Eq(_) | Ne(_) | Lt(_) | Le(_) | Gt(_) | Ge(_) => Form::Comparison {
                left,
                operator,
                right,
            },
            Add(_) | Sub(_) | Mul(_) | Div(_) | Rem(_) | BitAnd(_) | BitOr(_) | BitXor(_)
            | Shl(_) | Shr(_) => Form::Arithmetic {
                left,
                operator,
                right,
            },
            _ => Form::Assignment {
                left,
                operator,
                right,
            },
        };
        self.place(Genre::BinaryOperator, binary.op.span(), bytes(binary), form);
        visit::visit_expr_binary(self, binary);
    }

    fn visit_expr_unary(&mut self, unary: &'ast syn::ExprUnary) {
        let form = Form::Unary {
            operator: unary.op.span().source_text().unwrap_or_default(),
            operand: bytes(&unary.expr),
        };
        self.place(Genre::UnaryOperator, unary.op.span(), bytes(unary), form);
        visit::visit_expr_unary(self, unary);
    }

    fn visit_arm(&mut self, arm: &'ast syn::Arm) {
        let range = match &arm.guard {
            Some((_, guard)) => bytes(guard),
            None => {
                let behind = bytes(&arm.pat).end;
                behind..behind
            }
        };
        let guarded = arm.guard.is_some();
        let span = arm.span();
        self.place(Genre::Arm, span, range, Form::Arm { guarded });
        if let Some((_, guard)) = &arm.guard {
            self.place(Genre::ArmGuard, guard.span(), bytes(guard), Form::Guard);
        }
        visit::visit_arm(self, arm);
    }

    fn visit_expr_struct(&mut self, whole: &'ast syn::ExprStruct) {
        if let Some(rest) = &whole.rest {
            for field in &whole.fields {
                let form = Form::Field {
                    name: field.member.span().source_text().unwrap_or_default(),
                    rest: bytes(rest),
                };
                if field.colon_token.is_some() {
                    let range = bytes(&field.expr);
                    self.place(Genre::Field, field.span(), range, form);
                }
            }
        }
        visit::visit_expr_struct(self, whole);
    }
}

struct Writer<'a> {
    schemata: &'a Schemata<'a>,
    first: usize,
    left_out: &'a BTreeSet<usize>,
}

impl Writer<'_> {
    /// A part of the text; places before `from` are around it.
    fn range(&self, range: Bytes, from: usize) -> String {
        let mut written = String::new();
        let mut done = range.start;
        for (index, place) in self.schemata.places.iter().enumerate().skip(from) {
            // Within one that is written already, or behind.
            if place.range.start < done || place.range.end > range.end {
                continue;
            }
            written += &self.schemata.text[done..place.range.start];
            written += &self.place(index);
            done = place.range.end;
        }
        written + &self.schemata.text[done..range.end]
    }

    fn place(&self, index: usize) -> String {
        let place = &self.schemata.places[index];
        let number = self.first + index;
        let part = |range: &Bytes| self.range(range.clone(), index + 1);
        let whole = || part(&place.range);
        let choices: Vec<(usize, usize)> = place.mutants.iter().copied().enumerate().collect();
        let choices: Vec<(usize, usize)> = choices
            .into_iter()
            .filter(|(_, mutant)| !self.left_out.contains(mutant))
            .map(|(at, mutant)| (at + 1, mutant))
            .collect();
        if choices.is_empty() {
            return whole();
        }
        let original = |text: &str| format!("\n{PLACE}{number}*/ {text}\n");
        let mutated = |mutant: usize, text: &str| format!("\n{MUTANT}{mutant}*/ {text}\n");
        let replacement = |mutant: usize| self.schemata.mutants[mutant].replacement.as_str();
        let at = format!("crate::switches::at({number})");
        let choice = format!("crate::switches::choice({number})");
        match &place.form {
            Form::Arithmetic {
                left,
                operator,
                right,
            } => {
                let (left, right) = (part(left), part(right));
                let value = |o: &str| format!("__left {o} __right");
                let arms = self.compared(number, &choices, &value(operator), |m| {
                    value(replacement(m))
                });
                format!(
                    "(match ({left}, {right}) {{ (__left, __right) => match {at} {{ {arms} }} }})"
                )
            }
            Form::Comparison {
                left,
                operator,
                right,
            } => {
                let (left, right) = (part(left), part(right));
                let value = |o: &str| format!("*__left {o} *__right");
                let arms = self.compared(number, &choices, &value(operator), |m| {
                    value(replacement(m))
                });
                format!(
                    "(match (&({left}), &({right})) {{ (__left, __right) => match {at} {{ {arms} }} }})"
                )
            }
            Form::Lazy { left, and, right } => {
                // The operand on the right decides where the one on the left does not: where it is true for `&&`, false for `||`,
                // the other way round for the mutant.
                let (left, right) = (part(left), part(right));
                let decides = if *and { "!=" } else { "==" };
                format!("({{ let __left: bool = {left}; if __left {decides} ({choice} != 0) {{ {right} }} else {{ __left }} }})")
            }
            Form::Assignment {
                left,
                operator,
                right,
            } => {
                let (left, right) = (part(left), part(right));
                let mut arms = String::new();
                for (at, mutant) in &choices {
                    let value = format!("{left} {} __right", replacement(*mutant));
                    let value = mutated(*mutant, &value.replace('\n', " "));
                    let _ = write!(arms, "{at} => {{ {value} }} ");
                }
                let value = original(&format!("{left} {operator} __right"));
                format!(
                    "(match ({right}) {{ __right => match {choice} {{ {arms} _ => {{ {value} }} }} }})"
                )
            }
            Form::Unary { operator, operand } => {
                let operand = part(operand);
                let (value, mutant) = (
                    original(&format!("{operator}__operand")),
                    mutated(choices[0].1, "__operand"),
                );
                format!("(match ({operand}) {{ __operand => match {choice} {{ 0 => {value}, _ => {mutant} }} }})")
            }
            Form::Body => {
                let mut arms = String::new();
                for (at, mutant) in &choices {
                    let value = mutated(*mutant, &format!("return {}", replacement(*mutant)));
                    let _ = write!(arms, "{at} => {value}, ");
                }
                format!(" match {choice} {{ {arms} _ => {{}} }} ")
            }
            Form::Guard => {
                let mut arms = String::new();
                for (at, mutant) in &choices {
                    let _ = write!(arms, "{at} => {}, ", replacement(*mutant));
                }
                format!("(match {choice} {{ {arms} _ => {} }})", whole())
            }
            Form::Arm { guarded: false } => format!(" if {choice} == 0 "),
            Form::Arm { guarded: true } => format!("{choice} == 0 && ({})", whole()),
            Form::Field { name, rest } => {
                let rest = part(rest);
                let value = mutated(choices[0].1, &format!("({rest}).{name}").replace('\n', " "));
                format!("(match {choice} {{ 0 => {}, _ => {value} }})", whole())
            }
        }
    }

    /// The arms of the choice between the original and its mutants, and of the look at all of them.
    fn compared(
        &self,
        number: usize,
        choices: &[(usize, usize)],
        value: &str,
        of: impl Fn(usize) -> String,
    ) -> String {
        let original = format!("\n{PLACE}{number}*/ {value}\n");
        let mut arms = format!("0 => {original}, ");
        for (at, mutant) in choices {
            let _ = write!(arms, "{at} => \n{MUTANT}{mutant}*/ {}\n, ", of(*mutant));
        }
        let list: Vec<String> = choices.iter().map(|(at, _)| at.to_string()).collect();
        let list = list.join(", ");
        let mut again = String::new();
        for (k, (at, mutant)) in choices.iter().enumerate() {
            let last = k + 1 == choices.len();
            let at = if last { "_".into() } else { at.to_string() };
            let _ = write!(again, "{at} => \n{MUTANT}{mutant}*/ {}\n, ", of(*mutant));
        }
        format!("{arms} _ => crate::switches::compare({number}, &[{list}], {original}, |choice| match choice {{ {again} }})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text with mutants of these operators, each with its replacements.
    fn rewritten(text: &str, asked: &[(Genre, &str, &[&str])]) -> (String, usize) {
        let mut mutants = Vec::new();
        for (genre, at, replacements) in asked {
            let before = &text[..text.find(at).expect("it is in the text")];
            let start = Position {
                line: before.matches('\n').count() + 1,
                column: before.chars().rev().take_while(|c| *c != '\n').count() + 1,
            };
            for replacement in *replacements {
                mutants.push(Mutant {
                    name: String::new(),
                    file: String::new(),
                    genre: *genre,
                    start,
                    end: start,
                    replacement: replacement.to_string(),
                });
            }
        }
        let all: Vec<usize> = (0..mutants.len()).collect();
        let schemata = Schemata::find(text, &mutants, &all).expect("it parses");
        let written = schemata.write(0, &BTreeSet::new());
        syn::parse_file(&written).unwrap_or_else(|e| panic!("{e}:\n{written}"));
        // Without its mutants it is the text itself.
        assert_eq!(schemata.write(0, &all.iter().copied().collect()), text);
        (written, schemata.places().len())
    }

    #[test]
    fn operators_within_one_another_are_written_once() {
        use Genre::BinaryOperator;
        let text = "fn f(a: f64, b: f64, c: f64) -> f64 {\n    a * b + c\n}\n";
        let asked: [(_, _, &[&str]); 2] = [
            (BinaryOperator, "* b", &["+", "/"]),
            (BinaryOperator, "+ c", &["-", "*"]),
        ];
        let (written, places) = rewritten(text, &asked);
        assert_eq!(places, 2);
        assert_eq!(written.matches("(match (a, b)").count(), 1);
        assert!(written.contains("__left - __right"));
    }

    #[test]
    fn each_kind_of_place_is_found() {
        let text = "\
fn f(p: Point, n: i32) -> i32 {
    let mut sum = -1;
    if n > 2 && p.x < 3 {
        sum += n;
    }
    let q = Point { x: 7, ..p };
    match n {
        1 => 4,
        2 if p.y == 0 => 5,
        _ => sum,
    }
}
";
        use Genre::*;
        let asked: [(_, _, &[&str]); 9] = [
            (FunctionValue, "let mut", &["0", "1", "-1"]),
            (UnaryOperator, "-1", &[""]),
            (BinaryOperator, "&&", &["||"]),
            (BinaryOperator, "> 2", &["==", "<", ">="]),
            (BinaryOperator, "+= n", &["-=", "*="]),
            (Field, "x: 7", &[""]),
            (Arm, "1 => 4", &[""]),
            (Arm, "2 if", &[""]),
            (ArmGuard, "p.y ==", &["true", "false"]),
        ];
        let (written, places) = rewritten(text, &asked);
        assert_eq!(places, 9, "{written}");
    }

    #[test]
    fn what_a_compiler_evaluates_is_left_alone() {
        let text = "const A: f64 = 2.0 * 3.0;\nfn f() -> [f64; 1 + 2] {\n    [A; 1 - 2]\n}\n";
        use Genre::BinaryOperator;
        let asked: [(_, _, &[&str]); 3] = [
            (BinaryOperator, "* 3", &["+"]),
            (BinaryOperator, "+ 2", &["-"]),
            (BinaryOperator, "- 2", &["+"]),
        ];
        let (written, places) = rewritten(text, &asked);
        assert_eq!((written.as_str(), places), (text, 0));
    }

    #[test]
    fn lines_say_whose_they_are() {
        let text = "fn f(a: f64) -> f64 {\n    a - 1.0\n}\n";
        let (written, _) = rewritten(text, &[(Genre::BinaryOperator, "- 1", &["+"])]);
        let owners: Vec<Owner> = written.lines().filter_map(owner).collect();
        use Owner::*;
        assert_eq!(owners, [Place(0), Mutant(0), Place(0), Mutant(0)]);
    }

    #[test]
    fn one_mutant_alone_is_cut_in() {
        let mutant = Mutant {
            name: String::new(),
            file: String::new(),
            genre: Genre::BinaryOperator,
            start: Position { line: 2, column: 4 },
            end: Position { line: 2, column: 6 },
            replacement: "<".into(),
        };
        assert_eq!(
            changed("// é\né: >= 2\n", &mutant).unwrap(),
            "// é\né: < 2\n"
        );
    }
}
