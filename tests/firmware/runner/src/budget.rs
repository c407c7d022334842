//! What an image may take: `budgets.toml`.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use crate::figures::Figures;

/// A figure may be this share above its budget; more below it, and the budget can be tightened.
const SLACK: f64 = 0.02;

const TEXT: &str = "# What images may take, within 2 %: target, scene, figure. Instructions are \
                    those of the emulated core.\n# `tests/firmware/run --write-budgets` writes \
                    this file anew.\n\n";

/// Budgets by image, each by figure.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Budgets {
    /// Version of the compiler that the figures are from.
    compiler: String,
    image: BTreeMap<String, BTreeMap<String, u64>>,
}

impl Budgets {
    pub fn read(path: &Path) -> Result<Self> {
        let why = || format!("{}: --write-budgets writes it", path.display());
        let text = std::fs::read_to_string(path).with_context(why)?;
        toml::from_str(&text).with_context(|| path.display().to_string())
    }

    pub fn write(&self, path: &Path) -> Result<()> {
        Ok(std::fs::write(path, format!("{TEXT}{}", toml::to_string(self)?))?)
    }

    /// Takes the figures as budgets.
    pub fn take(&mut self, figures: &Figures, compiler: &str) {
        compiler.clone_into(&mut self.compiler);
        let own = held(figures).into_iter().map(|(name, value)| (name.to_owned(), value));
        self.image.insert(key(figures), own.collect());
    }

    /// What the figures break, and what they leave room for.
    pub fn check(&self, figures: &Figures) -> Verdict {
        let name = key(figures);
        let Some(own) = self.image.get(&name) else {
            let why = format!("{name}: no budget; take it in with --write-budgets");
            return Verdict { broken: vec![why], loose: vec![] };
        };
        let mut verdict = Verdict { broken: vec![], loose: vec![] };
        for (figure, value) in held(figures) {
            let Some(&budget) = own.get(figure) else {
                verdict.broken.push(format!("{name}: no budget for {figure}"));
                continue;
            };
            let share = value as f64 / budget.max(1) as f64 - 1.0;
            let says =
                format!("{name}: {figure} {value}, budget {budget}, {:+.1} %", 100.0 * share);
            if share > SLACK {
                verdict.broken.push(says);
            } else if share < -SLACK {
                verdict.loose.push(says);
            }
        }
        verdict
    }

    /// The compiler that the budgets are for.
    pub fn compiler(&self) -> &str {
        &self.compiler
    }
}

/// Budgets broken, and such as can be tightened.
pub struct Verdict {
    pub broken: Vec<String>,
    pub loose: Vec<String>,
}

fn key(figures: &Figures) -> String {
    format!("{}-{}-{}", figures.target, figures.scene, figures.tier)
}

fn held(figures: &Figures) -> Vec<(&'static str, u64)> {
    let touch = figures.touch.iter().flat_map(|touch| {
        [
            ("instructions_per_sweep_touch", touch.instructions_per_sweep_touch),
            ("instructions_per_tick_touch", touch.instructions_per_tick_touch),
            ("instructions_without_tool", touch.instructions_without_tool),
        ]
    });
    let cut = figures.cut.iter().flat_map(|cut| {
        [
            ("instructions_per_tick_split", cut.instructions_per_tick_split),
            ("instructions_per_tick_whole", cut.instructions_per_tick_whole),
        ]
    });
    // REQ-TCK-03, REQ-TCK-04
    let all = [
        ("instructions_per_sweep_worst", figures.instructions_per_sweep_worst),
        ("instructions_per_tick_worst", figures.instructions_per_tick_worst),
        ("instructions_per_tick_rest", figures.instructions_per_tick_rest),
        ("flash_bytes", figures.flash_bytes),
        ("ram_bytes", figures.ram_bytes),
        ("stack_bytes", figures.stack_bytes),
    ];
    all.into_iter().chain(touch).chain(cut).collect()
}
