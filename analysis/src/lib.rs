//! Measurements on granular gases, their uncertainty, and verdicts.
