"""What programs of expressions are made of, by number; see `programs.py`. Without Warp, for scenes to know."""

CONSTANT, VARIABLE, CURVE = 0, 1, 2  # push a number; push a variable; a curve of the number on top
BINARY: dict[str, int] = {"+": 10, "-": 11, "*": 12, "/": 13, "^": 14, "min": 15, "max": 16}
UNARY: dict[str, int] = {
    name: 20 + number for number, name in enumerate((
        "negative", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "abs",
        "step",
    ))
}  # fmt: skip
DEEPEST = 16  # numbers that a program has at hand at once
MOST_VARIABLES = 8
