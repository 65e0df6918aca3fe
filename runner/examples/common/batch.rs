//! Batches of a challenge whose keys are open.

use runner::challenge::key::{Key, Secret, open};
use std::path::Path;

/// Of arguments FOLDER KEY SECRET, the last a file that holds it: the folder, and what the key says of its cases.
pub fn opened(batch: &[String]) -> Result<(&Path, Key), Box<dyn std::error::Error>> {
    let [folder, key, secret_file] = batch else {
        return Err("each batch: a folder, its key and secret".into());
    };
    let secret = Secret::of(&std::fs::read_to_string(secret_file)?);
    let secret = secret.ok_or_else(|| format!("{secret_file}: no secret"))?;
    let folder = Path::new(folder);
    Ok((folder, open(Path::new(key), folder, &secret)?))
}
