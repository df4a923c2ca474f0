//! The option `--tables`: further file formats for the tables of a run.

use crate::arguments::{TableArguments, TableFormat};
use crate::error::CommandError;
use crate::study::RunSummary;

impl TableArguments {
    /// Option that asks another command for the same formats, after a blank; empty if it is the
    /// default.
    pub(crate) fn option(&self) -> &'static str {
        if self.tables.contains(&TableFormat::Parquet) {
            " --tables parquet"
        } else {
            ""
        }
    }

    /// Checks that this program was built with support for the requested table formats.
    ///
    /// # Errors
    /// [`CommandError::NoParquet`].
    pub(crate) fn check(&self) -> Result<(), CommandError> {
        if cfg!(feature = "parquet") || !self.tables.contains(&TableFormat::Parquet) {
            Ok(())
        } else {
            Err(CommandError::NoParquet)
        }
    }

    /// Writes the tables of all points of a run as Parquet, if requested; CSV files are always
    /// there.
    ///
    /// # Errors
    /// [`CommandError::Results`] or [`CommandError::Report`] if a table cannot be read, or a file
    /// cannot be written.
    #[cfg(feature = "parquet")]
    pub(crate) fn write(&self, summary: &RunSummary) -> Result<(), CommandError> {
        use crate::report::sweep_table;
        use crate::results::{Manifest, write_file};

        if !self.tables.contains(&TableFormat::Parquet) {
            return Ok(());
        }
        for point in &summary.points {
            let manifest = Manifest::read(&point.folder)?;
            for entry in manifest.into_iter().flat_map(|one| one.tables) {
                let table = entry.read(&point.folder)?;
                let name = match point.name.as_str() {
                    "" => table.parquet_file(),
                    name => format!("{name}/{}", table.parquet_file()),
                };
                write_file(&summary.held.claim(&name)?, &table.to_parquet()?)?;
            }
        }
        if let Some(table) = sweep_table(&summary.folder)? {
            let path = summary.held.claim(&table.parquet_file())?;
            write_file(&path, &table.to_parquet()?)?;
        }
        Ok(())
    }

    /// Does nothing in a program without Parquet: CSV files are always there.
    #[cfg(not(feature = "parquet"))]
    pub(crate) fn write(&self, _summary: &RunSummary) -> Result<(), CommandError> {
        self.check()
    }
}
