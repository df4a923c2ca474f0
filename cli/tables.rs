//! Tables of a run in the formats that are asked for.

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

    /// Refuses formats that this program was built without.
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

    /// Writes the tables of all points of a run as Parquet, if asked for; CSV is there already.
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

    /// Writes nothing: CSV is there already.
    #[cfg(not(feature = "parquet"))]
    pub(crate) fn write(&self, _summary: &RunSummary) -> Result<(), CommandError> {
        self.check()
    }
}
