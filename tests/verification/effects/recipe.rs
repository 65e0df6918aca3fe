//! The recipe for a new effect in the documentation, followed to the letter.

use std::path::{Path, PathBuf};
use std::process::Command;

/// One step of the recipe: the sentence before a piece of code, and the code.
struct Step {
    words: String,
    code: String,
}

impl Step {
    /// What stands in backticks in the sentence.
    fn quoted(&self) -> Vec<&str> {
        self.words.split('`').skip(1).step_by(2).collect()
    }

    /// Does what the sentence says in the sources of the model.
    fn follow(&self, sources: &Path) {
        let quoted = self.quoted();
        let file = sources.join(quoted.iter().find(|name| name.ends_with(".rs")).expect("a file"));
        if self.words.contains("a new file") {
            assert!(!file.exists());
            return std::fs::write(file, &self.code).unwrap();
        }
        let (place, text) = (quoted[quoted.len() - 1], std::fs::read_to_string(&file).unwrap());
        assert_eq!(text.matches(place).count(), 1, "`{place}` stands once in {}", file.display());
        let new = if self.words.contains("in place of") {
            self.code.trim_end().to_owned()
        } else {
            format!("{place}\n{}", self.code.trim_end())
        };
        std::fs::write(file, text.replace(place, &new)).unwrap();
    }
}

fn steps(recipe: &str) -> Vec<Step> {
    let parts: Vec<&str> = recipe.split("```").collect();
    parts
        .chunks_exact(2)
        .map(|pair| Step {
            words: pair[0].rsplit("\n\n").find(|p| !p.trim().is_empty()).unwrap_or_default().to_owned(),
            code: pair[1].trim_start_matches("rust\n").to_owned(),
        })
        .collect()
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// Goal: whoever follows the recipe gets an effect that acts. Set-up: the model's sources copied, the recipe followed, two
/// runs of a ramp, one with the logarithm of two. Reference: the force of twice the stresses. Tolerance: 1e-6.
#[test]
#[ignore = "long: builds the model once more"]
fn the_recipe_makes_an_effect_that_acts() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = tempfile::TempDir::new().unwrap();
    copy(&root.join("fmu"), &folder.path().join("fmu"));
    std::fs::copy(root.join("Cargo.lock"), folder.path().join("Cargo.lock")).unwrap();
    let workspace = std::fs::read_to_string(root.join("Cargo.toml")).unwrap();
    let is_list = |line: &&str| line.starts_with("members") || line.starts_with("default-members");
    let others: Vec<&str> = workspace.lines().filter(|line| !is_list(line)).collect();
    let workspace = others.join("\n").replacen("[workspace]", "[workspace]\nmembers = [\"fmu\"]", 1);
    std::fs::write(folder.path().join("Cargo.toml"), workspace).unwrap();

    let sources = folder.path().join("fmu/src");
    let recipe = std::fs::read_to_string(sources.join("effect/recipe.md")).unwrap();
    let steps = steps(&recipe);
    assert_eq!(steps.len(), 3);
    steps.iter().for_each(|step| step.follow(&sources));
    let example = folder.path().join("fmu/examples/recipe.rs");
    std::fs::write(example, include_str!("recipe_example.rs.txt")).unwrap();
    let output = Command::new(env!("CARGO"))
        .args(["run", "--release", "--quiet", "--package", "poropunch", "--example", "recipe"])
        .current_dir(folder.path())
        .env("CARGO_TARGET_DIR", root.join("target/recipe"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let ratio: f64 = String::from_utf8_lossy(&output.stdout).trim().parse().unwrap();
    assert!((ratio - 2.0).abs() < 1e-6, "{ratio}");
}
