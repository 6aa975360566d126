"""Files of records as loggers, spreadsheets and accidents leave them."""

import gzip

import numpy as np
from recipes import recipe

HEADER = ["t_s", "command_position_m", "robot_position_m"]


def motion(rows=4000, seed=1, noise_m=1e-6):
    """t_s, command and robot of a robot that does as it is told, 17.5 ms late."""
    t_s = 0.0025 * np.arange(rows)
    command_m = 0.01 * np.sin(2 * np.pi * 0.7 * t_s) + 0.003 * np.sin(2 * np.pi * 2.3 * t_s + 1.0)
    robot_m = np.interp(t_s - 0.0175, t_s, command_m)
    return [t_s, command_m, robot_m + noise_m * np.random.default_rng(seed).standard_normal(rows)]


def lines_of(header, columns):
    return [",".join(header)] + [",".join(repr(float(value)) for value in row) for row in zip(*columns)]


@recipe()
def table_of(folder, change=None, name="record.csv", rows=4000, rig=None, **given):
    """`change(header, columns, **given)`: new ones; `rig`: the text of a rig file."""
    header, columns = (list(HEADER), motion(rows))
    if change:
        header, columns = change(header, columns, **given)
    data = ("\n".join(lines_of(header, columns)) + "\n").encode()
    (folder / name).write_bytes(gzip.compress(data) if name.endswith(".gz") else data)
    if rig is not None:
        (folder / "rig.toml").write_text(rig)


@recipe()
def text_of(folder, change, name="record.csv", **given):
    """`change(lines, **given)`: the lines of a good record become a text or bytes."""
    made = change(lines_of(HEADER, motion()), **given)
    (folder / name).write_bytes(made if isinstance(made, bytes) else made.encode())


@recipe()
def content(folder, data, name="record.csv"):
    (folder / name).write_bytes(data)


@recipe()
def two_files(folder, role="validate", packed=False, shift_s=None, seed=2):
    """A record and one beside it: the same packed, the same at another time, or another measurement."""
    columns = motion()
    lines = "\n".join(lines_of(HEADER, columns)) + "\n"
    (folder / "record.csv").write_text(lines)
    if packed:
        (folder / f"{role}.csv.gz").write_bytes(gzip.compress(lines.encode()))
    elif shift_s is not None:
        shifted = "\n".join(lines_of(HEADER, [columns[0] + shift_s, *columns[1:]])) + "\n"
        (folder / f"{role}.csv").write_text(shifted)
    else:
        (folder / f"{role}.csv").write_text("\n".join(lines_of(HEADER, motion(seed=seed))) + "\n")


# --- columns ------------------------------------------------------------------------------------------------------
def cell(header, columns, column, value, row=70):
    columns[column][row] = value
    return header, columns


def doubled_time(header, columns):
    return header, [2 * columns[0], *columns[1:]]


def back_in_time(header, columns):
    columns[0][1000:] -= 1.0
    return header, columns


def from_the_end(header, columns):
    return header, [column[::-1] for column in columns]


def rounded_stamps(header, columns):
    return header, [np.round(columns[0], 2), *columns[1:]]


def stamps_since_1970(header, columns):
    return ["t_us", *header[1:]], [1732700000000000 + np.round(1e6 * columns[0]), *columns[1:]]


def since_1970(header, columns, factor):
    return header, [factor * (1.77e9 + columns[0]), *columns[1:]]


def encoder_in_mm(header, columns):
    return [*header[:2], "encoder_mm"], [*columns[:2], 1e3 * columns[2]]


def gaps_and_jitter(header, columns):
    t_s, command_m, robot_m = columns
    kept = np.r_[0:1500, 1600:4000]
    jittered_s = t_s + 1e-4 * np.random.default_rng(2).uniform(-1, 1, len(t_s))
    return header, [jittered_s[kept], command_m[kept], robot_m[kept]]


def renamed(header, columns, **names):
    return [names.get(name, name) for name in header], columns


def in_mm(header, columns):
    return [header[0], "command_position_mm", header[2]], [columns[0], 1e3 * columns[1], columns[2]]


def only(header, columns, *names):
    return list(names), [columns[header.index(name)] for name in names]


def robot_alone(header, columns):
    return only(header, columns, "t_s", "robot_position_m")


def still_robot(header, columns):
    return header, [*columns[:2], 0 * columns[2]]


def with_more(header, columns, names, of):
    """Further columns of these names, each like the column of that number."""
    return [*header, *names], [*columns, *(columns[number] for number in of)]


def encoder(header, columns, both):
    """The robot's position as `encoder`: twice, or beside another column of the signal's own name."""
    if both:
        return [*header, "encoder"], [*columns[:2], 0 * columns[2], columns[2]]
    return ["t_s", "command_position_m", "encoder", "encoder"], [*columns, columns[2]]


def still_operator(header, columns, force_N, has_force):
    t_s, command_m, robot_m = columns
    names = ["t_s", "operator_force_N", "command_position_m"]
    made = [t_s, 0 * t_s + force_N, command_m]
    return (names + ["force_N"], made + [100.0 * robot_m]) if has_force else (names, made)


def force_z(header, columns):
    t_s, command_m, robot_m = columns
    return ["t_s", "command_position_m", "force_z_N"], [t_s, command_m, 100 * robot_m]


def in_labelled_parts(header, columns, last):
    return [*header, "part"], [*columns, np.linspace(1.0, 2.0, 4000) if last == 2 else np.arange(4000)]


# --- texts --------------------------------------------------------------------------------------------------------
def with_a_cell_too_many(lines):
    lines[50] += ",0.5"
    return "\n".join(lines) + "\n"


def encoded(lines, encoding):
    return "\n".join(lines).encode(encoding)


def with_blanks(lines):
    return "\n".join(lines).replace(",", " ") + "\n"


def from_a_spreadsheet(lines, separator):
    """With decimal commas, a preamble and a row of units."""
    table = [line.replace(",", separator).replace(".", ",") for line in lines]
    return "\n".join(["Measured: 4.3.2026", "", table[0], separator.join("smm"), *table[1:]]) + "\n"


def named_in_units(lines, names, units):
    return "\n".join([names, *([units] if units else []), *lines[1:]]) + "\n"


def dated(lines):
    """ISO stamps, over midnight."""
    def stamp(line):
        t_s, _, rest = line.partition(",")
        t = float(t_s)
        return (f"2026-03-04T23:59:{55 + t:06.3f}" if t < 5 else f"2026-03-05T00:00:{t - 5:06.3f}") + "," + rest

    return "\n".join([lines[0], *map(stamp, lines[1:])])


def quoted(lines):
    """A column that nobody needs comes first; its name has a comma and a quote."""
    names = ['"Force, sensor ""A"""', *(f'"{name}"' for name in HEADER)]
    return "\n".join([",".join(names), *("0.5," + line for line in lines[1:])])


def without_header(lines):
    return "\n".join(["# " + lines[0], *lines[1:]])


def with_ends(lines, end):
    return end.join(lines) + end


WRONG_LINE = 1007  # of the file that `commented` makes: row 1 000 behind the header and five lines that are no row


def commented(lines, end, damage):
    """With comments and empty lines between; in WRONG_LINE time goes back, or a cell is no number."""
    cells = lines[1001].split(",")
    cells[0] = lines[999].split(",")[0] if damage == "time" else cells[0]
    cells[1] = "x" + cells[1] if damage == "cell" else cells[1]
    lines[1001] = ",".join(cells)
    return end.join(["# measured on a Monday", "", *lines[:500], "", "# a break", "", *lines[500:]])


def packed(lines, cut=None, hole=False, twice=False):
    data = ("\n".join(lines) + "\n" * twice).encode()
    if twice:
        return gzip.compress(data[:70001]) + gzip.compress(data[70001:]) + bytes(512)
    whole = gzip.compress(data)
    if hole:
        return whole[:200] + bytes(100) + whole[300:]
    return whole[:len(whole) // 2] if cut == "half" else whole[:cut]
