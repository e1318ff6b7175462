// SPDX-License-Identifier: MIT OR Apache-2.0
//! LAMMPS: which release, its source tree, its binary.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{bail, Context, Result};

use crate::process::{ninja, output_of, run_logged};
use crate::progress::say;
use crate::{apt_source, cache, setup, tarball};

/// The oldest supported release, which a stable Debian keeps.
pub const OLDEST: &str = "20250204";

/// Suites of Debian, those with the newest releases first.
const SUITES: [&str; 5] = ["experimental", "sid", "testing", "stable", "oldstable"];

/// How long the answer holds which release is the newest.
const LOOK_AGAIN_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

const VERSION_VARIABLE: &str = "ELLGRAN_LAMMPS_VERSION";
const SOURCE_VARIABLE: &str = "ELLGRAN_LAMMPS_SOURCE";

/// Contact styles, plugins, rigid bodies, and what their tests run; all else would only cost build time.
const CONFIGURATION: &[&str] = &[
    "-DCMAKE_BUILD_TYPE=Release",
    "-DBUILD_MPI=on",
    "-DBUILD_OMP=on",
    "-DBUILD_SHARED_LIBS=off",
    "-DBUILD_TOOLS=off",
    "-DPKG_GRANULAR=on",
    "-DPKG_ASPHERE=on",
    "-DPKG_PLUGIN=on",
    "-DPKG_RIGID=on",
    "-DPKG_MOLECULE=on",
    "-DPKG_OPENMP=on",
    "-DWITH_JPEG=off",
    "-DWITH_PNG=off",
    "-DWITH_FFMPEG=off",
    "-DWITH_CURL=off",
    "-DDOWNLOAD_POTENTIALS=off",
];

/// A source tree, ours in the cache or the user's own.
pub struct Source {
    pub directory: PathBuf,
    /// The release, or a name made of the path of a user's own tree: the key of everything built from it.
    pub name: String,
    own: bool,
}

/// The source tree that the environment asks for, else the newest that can be had.
pub fn source() -> Result<Source> {
    if let Some(directory) = std::env::var_os(SOURCE_VARIABLE).filter(|value| !value.is_empty()) {
        return own_source(Path::new(&directory));
    }
    match std::env::var(VERSION_VARIABLE) {
        Ok(version) if !version.is_empty() => source_of(&version),
        _ => newest_source(),
    }
}

/// The source tree of one release, named by its date: `20260704`.
pub fn source_of(version: &str) -> Result<Source> {
    if !is_supported(version) {
        bail!(
            "{VERSION_VARIABLE}={version}: a release of LAMMPS is wanted, as eight digits, {OLDEST} or later"
        );
    }
    match fetched(version).map_err(explain)? {
        Some(source) => Ok(source),
        None => Err(explain(anyhow::anyhow!(
            "Debian has no LAMMPS {version} in {}",
            SUITES.join(", ")
        ))),
    }
}

fn is_supported(version: &str) -> bool {
    version.len() == OLDEST.len()
        && version.bytes().all(|b| b.is_ascii_digit())
        && version >= OLDEST
}

/// The oldest supported release and the newest that can be had, each fetched when it is asked for.
pub fn oldest_and_newest() -> impl Iterator<Item = (&'static str, Result<Source>)> {
    let sources: [(_, fn() -> Result<Source>); 2] = [
        ("the oldest supported release", || source_of(OLDEST)),
        ("the newest release that can be had", newest_source),
    ];
    sources.into_iter().map(|(name, source)| (name, source()))
}

/// The newest release that a suite has. Where none can be asked, the newest that was fetched before.
fn newest_source() -> Result<Source> {
    let mut candidates = vec![newest_version()?];
    candidates.extend(in_cache()?);
    candidates.push(OLDEST.to_string());
    let mut reasons = Vec::new();
    for version in candidates {
        match fetched(&version) {
            Ok(Some(source)) => return Ok(source),
            Ok(None) => reasons.push(format!("no LAMMPS {version} in {}", SUITES.join(", "))),
            Err(error) => reasons.push(format!("{error:#}")),
        }
        say(reasons.last().map(String::as_str).unwrap_or_default());
    }
    Err(explain(anyhow::anyhow!(reasons.join("; "))))
}

/// By version, in whatever suite; asked once a day.
fn newest_version() -> Result<String> {
    let _lock = cache::lock("lammps-newest")?;
    let memory = cache::directory()?.join("lammps-newest");
    let remembered = fs::read_to_string(&memory)
        .map(|text| text.trim().to_string())
        .ok()
        .filter(|version| is_supported(version));
    let fresh = fs::metadata(&memory)
        .and_then(|data| data.modified())
        .is_ok_and(|time| time.elapsed().is_ok_and(|age| age < LOOK_AGAIN_AFTER));
    if let (Some(version), true) = (&remembered, fresh) {
        return Ok(version.clone());
    }
    let mut failure = None;
    for suite in SUITES {
        match apt_source::versions("lammps", suite) {
            Ok(versions) => {
                let releases = versions.iter().filter_map(|version| release_of(version));
                if let Some(version) = releases.max() {
                    fs::write(&memory, &version)?;
                    return Ok(version);
                }
            }
            Err(error) => failure = Some(error),
        }
    }
    let known = remembered.or(in_cache()?.into_iter().next());
    match (known, failure) {
        (Some(version), _) => Ok(version),
        (None, Some(error)) => Err(explain(error)),
        (None, None) => Ok(OLDEST.to_string()),
    }
}

/// The release in the version of a Debian package, `20260704+dfsg-2`, if it is supported.
fn release_of(version: &str) -> Option<String> {
    let digits = version.split(|c: char| !c.is_ascii_digit()).next()?;
    is_supported(digits).then(|| digits.to_string())
}

/// Releases that were fetched before, the newest first.
fn in_cache() -> Result<Vec<String>> {
    let mut versions: Vec<String> = fs::read_dir(cache::directory()?)?
        .filter_map(|entry| {
            let entry = entry.ok()?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let version = name.strip_prefix("lammps-")?;
            (is_supported(version) && entry.path().join("source").is_dir())
                .then(|| version.to_string())
        })
        .collect();
    versions.sort();
    versions.reverse();
    Ok(versions)
}

fn explain(error: anyhow::Error) -> anyhow::Error {
    error.context(format!(
        "the LAMMPS source cannot be had through apt; name a source tree of your own (4 Feb 2025 or later) with {SOURCE_VARIABLE}=/path/to/lammps"
    ))
}

fn own_source(directory: &Path) -> Result<Source> {
    let directory = directory
        .canonicalize()
        .with_context(|| format!("{SOURCE_VARIABLE}={}", directory.display()))?;
    for file in ["src/version.h", "cmake/CMakeLists.txt"] {
        if !directory.join(file).is_file() {
            bail!(
                "{SOURCE_VARIABLE}={}: no {file} there; the top directory of a LAMMPS source tree is wanted",
                directory.display()
            );
        }
    }
    let name = format!("own-{}", cache::key(&[&directory.to_string_lossy()]));
    Ok(Source {
        directory,
        name,
        own: true,
    })
}

/// The unpacked release in the cache, fetched when missing; `None` when no suite has it.
fn fetched(version: &str) -> Result<Option<Source>> {
    let name = version.to_string();
    let _lock = cache::lock(&format!("lammps-source-{name}"))?;
    let home = cache::directory()?.join(format!("lammps-{name}"));
    let directory = home.join("source");
    if !directory.is_dir() {
        cache::need_space(&cache::directory()?, 1500)?;
        let mut suites = SUITES;
        if version == OLDEST {
            suites.reverse();
        }
        let Some(package) = apt_source::find_in("lammps", version, &suites)? else {
            return Ok(None);
        };
        let download = tempfile::Builder::new()
            .prefix("download-")
            .tempdir_in(cache::directory()?)?;
        let tarball = package.download(download.path())?;
        tarball::unpack(
            &tarball,
            &directory,
            &[
                "doc",
                "examples",
                "bench",
                "potentials",
                "tools",
                "unittest",
            ],
        )?;
    }
    Ok(Some(Source {
        directory,
        name,
        own: false,
    }))
}

impl Source {
    /// The directory of the headers.
    pub fn src(&self) -> PathBuf {
        self.directory.join("src")
    }

    /// The release as LAMMPS spells it, `4 Jul 2026`.
    pub fn spelled(&self) -> Result<String> {
        let path = self.src().join("version.h");
        let text =
            fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        version_of(&text).with_context(|| format!("no LAMMPS_VERSION in {}", path.display()))
    }

    /// The binary, built when missing.
    pub fn binary(&self) -> Result<PathBuf> {
        setup::setup()?;
        let spelled = self.spelled()?;
        // The MPI wrapper's own line: a binary linked with one MPI does not run under another's launcher.
        let mpi = output_of(Command::new("mpicxx").arg("-show"))?;
        let mut parts = CONFIGURATION.to_vec();
        parts.push(&mpi);
        let build = cache::directory()?
            .join(format!("lammps-{}", self.name))
            .join(format!("build-{}", cache::key(&parts)));
        let binary = build.join("lmp");
        let _lock = cache::lock(&format!("lammps-build-{}", self.name))?;
        let stamp = cache::stamp(&build);
        // A user's own tree may have changed since: ninja looks.
        if stamp.is_file() && binary.is_file() && !self.own {
            say(format!("LAMMPS {spelled} is in the cache"));
            return Ok(binary);
        }
        fs::create_dir_all(&build)?;
        cache::need_space(&build, 1000)?;
        say(format!(
            "Building LAMMPS {spelled} in {} (once; 4 to 5 minutes on two cores)",
            build.display()
        ));
        let mut configure = Command::new("cmake");
        configure
            .arg("-S")
            .arg(self.directory.join("cmake"))
            .arg("-B")
            .arg(&build)
            .args(["-G", "Ninja"])
            .args(CONFIGURATION);
        run_logged(&mut configure, &build.join("configure.log"), |_| {})
            .context("LAMMPS cannot be configured")?;
        ninja(&build, &["lmp"], &format!("Building LAMMPS {spelled}"))
            .context("LAMMPS cannot be built")?;
        fs::write(&stamp, &spelled)?;
        Ok(binary)
    }
}

fn version_of(header: &str) -> Option<String> {
    let rest = header
        .lines()
        .find_map(|line| line.trim().strip_prefix("#define LAMMPS_VERSION"))?;
    Some(rest.trim().trim_matches('"').to_string())
}

#[cfg(test)]
mod tests {
    use super::{release_of, version_of};

    #[test]
    fn the_release_is_read_from_the_version_of_its_package() {
        assert_eq!(release_of("20260704+dfsg-2").as_deref(), Some("20260704"));
        assert_eq!(release_of("20260930-1").as_deref(), Some("20260930"));
        assert_eq!(release_of("20220106.git7586adbb6a+ds1-2"), None);
        assert_eq!(release_of("1:5.0"), None);
    }

    #[test]
    fn the_release_is_read_from_its_header() {
        assert_eq!(
            version_of("#define LAMMPS_VERSION \"4 Jul 2026\"\n").as_deref(),
            Some("4 Jul 2026")
        );
        assert_eq!(version_of("#pragma once\n"), None);
    }
}
