"""Loads the tables beside this file into the data frames `responses`, `participants` and `stimuli`.

python load.py prints what there is; `from load import responses` takes it over. Types and categories are
those of codebook.csv; `responses.attrs` has the labels of the columns, their units and what levels mean.
"""
# STUDY

from pathlib import Path

import pandas as pd

FOLDER = Path(__file__).resolve().parent


def read_text(file):
    return pd.read_csv(FOLDER / file, dtype=str, keep_default_na=False, na_values=[""])


def lines_of(text):
    return [] if pd.isna(text) else text.split("\n")


def as_whole_number(text):
    # Seeds have 64 bits: beyond the signed integers, and beyond what a float keeps.
    numbers = [pd.NA if pd.isna(number) else int(number) for number in text]
    large = any(number > 2**63 - 1 for number in numbers if number is not pd.NA)
    return pd.array(numbers, dtype="UInt64" if large else "Int64")


CONVERT = {
    "integer": as_whole_number,
    "number": lambda text: text.astype("float64"),
    "boolean": lambda text: text.map({"true": True, "false": False}).astype("boolean"),
    "datetime": lambda text: pd.to_datetime(text, utc=True, format="ISO8601").dt.as_unit("us"),
    "string": lambda text: text.astype("string"),
}


def load_table(file):
    """The table in `file`, with the types that the codebook says."""
    table = read_text(file)
    labels, units, levels = {}, {}, {}
    for about in codebook[codebook["file"] == file].to_dict("records"):
        name, values = about["variable"], lines_of(about["levels"])
        labels[name] = about["description"]
        if not pd.isna(about["unit"]):
            units[name] = about["unit"]
        if values:
            levels[name] = dict(zip(values, lines_of(about["labels"])))
            table[name] = table[name].astype(pd.CategoricalDtype(values))
        else:
            table[name] = CONVERT[about["type"]](table[name])
    table.attrs = {"labels": labels, "units": units, "levels": levels}
    return table


codebook = read_text("codebook.csv")
responses = load_table("responses.csv")
participants = load_table("participants.csv")
stimuli = load_table("stimuli.csv")

if __name__ == "__main__":
    print("answers:", responses["study_kind"].iloc[0])
    tables = {"responses": responses, "participants": participants, "stimuli": stimuli}
    for name, table in tables.items():
        types = table.dtypes.map(lambda dtype: dtype.name).value_counts(sort=False).sort_index()
        types = ", ".join(f"{count} {dtype}" for dtype, count in types.items())
        print(f"{name}: {len(table)} rows, {len(table.columns)} columns ({types})")
    print(pd.crosstab(responses["kind"], responses["counts"]))
