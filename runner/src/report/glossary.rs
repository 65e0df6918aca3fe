//! The words of the pages, and what the symbols mean.

use maud::{Markup, html};
use poropunch::variables;

/// The page of the documentation that has the words: terms are its headings.
const PAGE: &str = include_str!("../../docs/pages/glossary.md");

/// Terms and what they mean, one paragraph each.
fn terms() -> impl Iterator<Item = (&'static str, &'static str)> {
    let sections = PAGE.split("\n### ").skip(1);
    sections
        .filter_map(|section| section.split_once('\n'))
        .map(|(term, meaning)| (term.trim(), meaning.trim()))
}

/// The glossary, folded.
pub fn glossary() -> Markup {
    html! {
        h2 id="glossary" { "Glossary" }
        details {
            summary { "χ², whitened, evidence, G, α, …" }
            dl { @for (term, meaning) in terms() { dt { (term) } dd { (meaning) } } }
        }
    }
}

/// What a parameter of poropunch's own model is; empty for others.
pub fn meaning(name: &str) -> &'static str {
    variables::by_name(name).map_or("", |(_, v)| v.description)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_of_the_page_has_its_meaning() {
        let all: Vec<_> = terms().collect();
        assert!(
            all.len() >= 12 && all.iter().all(|(term, meaning)| term.len() < 20 && meaning.ends_with('.')),
            "{all:?}"
        );
        assert!(all.iter().any(|(term, _)| *term == "evidence"), "{all:?}");
    }
}
