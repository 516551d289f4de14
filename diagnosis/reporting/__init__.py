"""What a diagnosis writes: the page, figures of residuals, FMUs compared with the recording."""
