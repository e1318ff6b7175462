// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where fetched sources and built engines stay between runs, and what keeps two runs from colliding there.

use std::fs::{File, TryLockError};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{bail, Context, Result};

use crate::process;
use crate::progress::say;

/// `$ELLGRAN_CACHE`, else `$XDG_CACHE_HOME/ellgran`, else `~/.cache/ellgran`; made when missing.
pub fn directory() -> Result<PathBuf> {
    let directory = chosen(|name| std::env::var_os(name).map(PathBuf::from))?;
    std::fs::create_dir_all(&directory)
        .with_context(|| format!("cannot make the cache directory {}", directory.display()))?;
    Ok(directory.canonicalize()?)
}

fn chosen(variable: impl Fn(&str) -> Option<PathBuf>) -> Result<PathBuf> {
    let set = |name: &str| variable(name).filter(|path| !path.as_os_str().is_empty());
    if let Some(path) = set("ELLGRAN_CACHE") {
        return Ok(path);
    }
    // A relative XDG path is invalid and to be ignored, says its specification.
    if let Some(path) = set("XDG_CACHE_HOME").filter(|path| path.is_absolute()) {
        return Ok(path.join("ellgran"));
    }
    match set("HOME") {
        Some(home) => Ok(home.join(".cache").join("ellgran")),
        None => bail!("neither ELLGRAN_CACHE nor XDG_CACHE_HOME nor HOME is set: set ELLGRAN_CACHE to a directory for the engines"),
    }
}

/// Held while something in the cache is made; released when dropped, also when the process dies.
pub struct Lock {
    _file: File,
}

pub fn lock(name: &str) -> Result<Lock> {
    let path = directory()?.join(format!("{name}.lock"));
    let file = File::create(&path).with_context(|| format!("cannot write {}", path.display()))?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            say(format!("another run is busy with {name}: waiting for it"));
            file.lock()?;
        }
        Err(TryLockError::Error(error)) => {
            return Err(error).with_context(|| format!("cannot lock {}", path.display()));
        }
    }
    Ok(Lock { _file: file })
}

/// Written last, so that a build that was cut short is not taken for a finished one.
pub fn stamp(directory: &Path) -> PathBuf {
    directory.join("finished")
}

/// A short name for a configuration.
pub fn key(parts: &[&str]) -> String {
    let mut hasher = DefaultHasher::new();
    parts.hash(&mut hasher);
    format!("{:016x}", hasher.finish())
}

/// Fails early, by name and number, where a build would fail late with half a file.
pub fn need_space(directory: &Path, megabytes: u64) -> Result<()> {
    let mut command = Command::new("df");
    command.arg("-Pk").arg(directory).env("LC_ALL", "C");
    // No df, or one that speaks otherwise: nothing is known, so nothing is refused.
    let Some(free) = process::output_of(&mut command)
        .ok()
        .and_then(|text| free_megabytes(&text))
    else {
        return Ok(());
    };
    if free < megabytes {
        bail!(
            "{} has {free} MB free, {megabytes} MB are needed; set ELLGRAN_CACHE to a directory with more room",
            directory.display()
        );
    }
    Ok(())
}

fn free_megabytes(df: &str) -> Option<u64> {
    let kilobytes: u64 = df.lines().nth(1)?.split_whitespace().nth(3)?.parse().ok()?;
    Some(kilobytes / 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen_from(pairs: &[(&str, &str)]) -> Result<PathBuf> {
        chosen(|name| {
            pairs
                .iter()
                .find(|(key, _)| *key == name)
                .map(|(_, value)| PathBuf::from(value))
        })
    }

    #[test]
    fn the_cache_is_where_the_environment_says() {
        let all = [
            ("ELLGRAN_CACHE", "/a"),
            ("XDG_CACHE_HOME", "/b"),
            ("HOME", "/c"),
        ];
        assert_eq!(chosen_from(&all).unwrap(), PathBuf::from("/a"));
        assert_eq!(chosen_from(&all[1..]).unwrap(), PathBuf::from("/b/ellgran"));
        assert_eq!(
            chosen_from(&all[2..]).unwrap(),
            PathBuf::from("/c/.cache/ellgran")
        );
        assert_eq!(
            chosen_from(&[("XDG_CACHE_HOME", "relative"), ("HOME", "/c")]).unwrap(),
            PathBuf::from("/c/.cache/ellgran")
        );
        assert!(chosen_from(&[("HOME", "")]).is_err());
    }

    #[test]
    fn the_free_space_is_the_fourth_column() {
        let text = "Filesystem 1024-blocks Used Available Capacity Mounted on\n/dev/sda1 1000 10 2048000 1% /\n";
        assert_eq!(free_megabytes(text), Some(2000));
        assert_eq!(free_megabytes("nonsense"), None);
    }
}
