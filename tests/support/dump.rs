// SPDX-License-Identifier: MIT OR Apache-2.0
//! Text dumps of LAMMPS and LIGGGHTS, read back.

/// What a dump holds of one step.
#[derive(Clone, Debug, Default)]
pub struct Table {
    pub step: u64,
    /// Both ends of the box along each axis.
    pub bounds: Vec<Vec<f64>>,
    pub columns: Vec<String>,
    /// Of atoms or of the entries of a local dump.
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    /// Where a column is.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|other| other == name)
    }
}

/// The tables of a dump in their order, or what is wrong with its text.
pub fn tables(text: &str) -> Result<Vec<Table>, String> {
    let (mut tables, mut next): (Vec<Table>, Table) = Default::default();
    let mut section = "";
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        if let Some(item) = line.strip_prefix("ITEM: ") {
            let (name, columns) = item.split_once(' ').unwrap_or((item, ""));
            section = name;
            if ["ATOMS", "ENTRIES"].contains(&section) {
                next.columns = columns.split_whitespace().map(str::to_owned).collect();
                tables.push(std::mem::take(&mut next));
            }
            continue;
        }
        let numbers: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        let row = numbers.map_err(|e| format!("not a row of numbers, {e}: {line}"))?;
        match (section, tables.last_mut()) {
            ("TIMESTEP", _) => next.step = row[0] as u64,
            ("BOX", _) => next.bounds.push(row),
            ("ATOMS" | "ENTRIES", Some(table)) if row.len() != table.columns.len() => {
                return Err(format!(
                    "a row of {} values under {:?}: {line}",
                    row.len(),
                    table.columns
                ));
            }
            ("ATOMS" | "ENTRIES", Some(table)) => table.rows.push(row),
            _ => (),
        }
    }
    Ok(tables)
}
