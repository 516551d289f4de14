"""Help: commands in the order of the work, under headings; examples at the end of the help of each command."""

from __future__ import annotations

import click

#: Commands under their headings.
SECTIONS = {
    "From a recording to a tire": ("inspect", "fit", "explore", "export", "check", "diagnose", "plan", "drive"),
    "All steps, many tires": ("studio", "init", "run", "fit-many", "study"),
    "Work with a tire": ("info", "evaluate", "draw", "compare"),
    "Other programs": ("generate", "convert", "lint"),
    "What there is": ("columns", "models", "effects", "published", "schema"),
    "To try it": ("demo", "example"),
}
#: Command lines without the name of the program, by command.
EXAMPLES = {
    "inspect": (
        "inspect cornering.mat drivebrake.mat -o page.html",
        'inspect run.csv --where "p in 70..90 kPa"',
        "inspect run.csv --columns Fy=FYC,alpha=-SA --units alpha=deg,Fz=lbf",
    ),
    "fit": (
        "fit cornering.mat drivebrake.mat --model mf61 -o my.tir --report fit.html",
        "fit run.csv --model mf96 --nominal Fz0=220,R0=0.23 --effects load_friction,camber_thrust -o my.tir",
        "fit run.csv --start my.tir --recipe scaling -o scaled.tir",
    ),
    "fit-many": (
        "fit-many jobs.toml -o tires --resume",
        "fit-many recordings --model mf61 --nominal Fz0=1000,R0=0.25 -o tires",
    ),
    "study": ("study my.fmu study.toml -o results",),
    "evaluate": (
        "evaluate my.tir table.csv -o forces.csv",
        "evaluate trento_hoosier run.mat -o forces.parquet --steady",
    ),
    "export": (
        "export my.tir -o my.fmu",
        "export my.tir -o my.fmu --proof run.csv",
        "export my.tir -o my.fmu --inputs wheel --fmi 2 --platforms all",
        "export my.tir --kind sti -o libmy.so",
        "export front.tir front.tir rear.tir rear.tir --ssp car.ssp",
    ),
    "check": ("check my.fmu run.csv", "check my.fmu", "check my.fmu run.csv --tolerance 0.05 --figures figures"),
    "diagnose": (
        "diagnose run.csv --tire my.tir -o answer",
        "diagnose run.csv --model mf61 --nominal Fz0=1100,R0=0.2 -o answer",
    ),
    "plan": (
        "plan --example",
        "plan similar.tir --bench bench.toml --minutes 20 -o program",
        "plan similar.tir --bench bench.toml --for friction --compare today.csv -o program",
        "plan my.tir --bench bench.toml --between slip_history,heat_friction -o program",
        "plan --bench bench.toml --after answer -o program",
    ),
    "drive": (
        "drive --example car.toml",
        "drive log.csv --vehicle car.toml --tire front.tir --rear rear.tir -o answer",
    ),
    "explore": (
        "explore my.tir -o tire.html",
        "explore my.tir run.csv --fit fit.json -o tire.html",
        "explore new.tir --compare trento_hoosier -o tires.html",
    ),
    "compare": ("compare old.tir new.tir run.csv -o comparison", "compare my.tir trento_hoosier -o comparison"),
    "generate": ("generate my.tir --language cpp -o code", "generate mf61 --language matlab --only Fy,Mz -o code"),
    "convert": ("convert my.tir --for adams -o adams.tir",),
    "lint": ("lint my.tir", "lint my.tir --for carsim"),
    "info": ("info my.tir", "info trento_hoosier --all"),
    "draw": ("draw my.tir -o figures", "draw unicamp_small_tire points.csv --kappa -1.1,1.1 -o figures"),
    "columns": ("columns",),
    "effects": ("effects --model mf61", "effects temp_friction"),
    "models": ("models", "models --json models.json"),
    "published": ("published",),
    "schema": ("schema", "schema recipe -o recipe.schema.json"),
    "example": (
        "example -o run.csv",
        "example -o small.csv --sample-rate 10 --tire my.tir",
        "example --program unicamp -o points.csv",
        "example --tire my.tir --program program/program.csv --bench bench.toml -o measured.csv",
    ),
    "init": ("init cornering.mat drivebrake.mat --model mf61 --nominal Fz0=1100,R0=0.2", "init"),
    "studio": ("studio", "studio cornering.mat drivebrake.mat"),
    "run": ("run", "run tirefmu.toml --force"),
    "demo": ("demo -o demo-output",),
}


class SectionedGroup(click.Group):
    """A group whose help lists its commands by `SECTIONS`."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands of each section with the first sentence of their help."""
        width = max(map(len, self.commands))
        for title, names in SECTIONS.items():
            with formatter.section(title):
                formatter.write_dl(
                    [(name.ljust(width), self.commands[name].get_short_help_str(formatter.width)) for name in names]
                )


def add_examples(group: click.Group) -> None:
    """Put the examples at the end of the help of each command of a group."""
    for name, lines in EXAMPLES.items():
        group.commands[name].epilog = "\b\nExamples:\n" + "\n".join(f"  tirefmu {line}" for line in lines)
