"""A language for tirefmu: the equations of a tire as a table in Markdown."""


def files(program):
    """Return the files of a printout by name."""
    rows = [f"| {line.number} | {line.symbol} | `{line.expression}` | {line.unit} |" for line in program.lines]
    header = ["| equation | symbol | expression | unit |", "|---|---|---|---|"]
    return {f"{program.name}.md": "\n".join([f"# {program.model.title}", "", *header, *rows]) + "\n"}
