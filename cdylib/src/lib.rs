//! FMI 2.0 face.
