"""Checks JSON against a schema (draft 2020-12), for the keywords that our schemas use. A keyword that is not known
here is an error of the schema: nothing is passed over in silence."""
import math
import re

TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None)}
REMARKS = {"$schema", "$id", "$defs", "title", "description"}


def is_of_type(value, name):
    if name in ("number", "integer"):
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        return is_number and (name == "number" or math.isfinite(value) and value == int(value))
    return isinstance(value, TYPES[name])


def is_same(a, b):
    """JSON's equality: true is not 1."""
    return a == b and isinstance(a, bool) == isinstance(b, bool)


class Checker:
    """Collects what is wrong, each with its place."""

    def __init__(self, root):
        self.root = root
        self.errors = []

    def check(self, value, schema, place):
        for keyword, argument in schema.items():
            if keyword in REMARKS:
                continue
            check = getattr(self, "check_" + keyword.lstrip("$"), None)
            if check is None:
                raise ValueError(f"the schema uses a keyword that is not known here: {keyword}")
            check(value, argument, schema, place)

    def complain(self, place, text):
        self.errors.append(f"{place or 'the whole'}: {text}")

    def check_ref(self, value, reference, _, place):
        found = self.root
        for name in reference.removeprefix("#/").split("/"):
            found = found[name]
        self.check(value, found, place)

    def check_type(self, value, names, _, place):
        names = names if isinstance(names, list) else [names]
        if not any(is_of_type(value, name) for name in names):
            self.complain(place, f"is no {' or '.join(names)}")

    def check_enum(self, value, choices, _, place):
        if not any(is_same(value, choice) for choice in choices):
            self.complain(place, f"{value!r} is none of {', '.join(map(str, choices))}")

    def check_const(self, value, wanted, _, place):
        if not is_same(value, wanted):
            self.complain(place, f"is {value!r}, not {wanted!r}")

    def check_minimum(self, value, least, _, place):
        if is_of_type(value, "number") and not value >= least:
            self.complain(place, f"{value} is less than {least}")

    def check_exclusiveMinimum(self, value, bound, _, place):
        if is_of_type(value, "number") and not value > bound:
            self.complain(place, f"{value} is not more than {bound}")

    def check_maximum(self, value, most, _, place):
        if is_of_type(value, "number") and not value <= most:
            self.complain(place, f"{value} is more than {most}")

    def check_pattern(self, value, pattern, _, place):
        if isinstance(value, str) and not re.search(pattern, value):
            self.complain(place, f"{value!r} does not match {pattern}")

    def check_minItems(self, value, count, _, place):
        if isinstance(value, list) and len(value) < count:
            self.complain(place, f"has {len(value)} items, fewer than {count}")

    def check_maxItems(self, value, count, _, place):
        if isinstance(value, list) and len(value) > count:
            self.complain(place, f"has {len(value)} items, more than {count}")

    def check_items(self, value, schema, _, place):
        if isinstance(value, list):
            for i, item in enumerate(value):
                self.check(item, schema, f"{place}[{i}]")

    def check_required(self, value, names, _, place):
        if isinstance(value, dict):
            for name in names:
                if name not in value:
                    self.complain(place, f"{name} is missing")

    def check_properties(self, value, properties, _, place):
        if isinstance(value, dict):
            for name, schema in properties.items():
                if name in value:
                    self.check(value[name], schema, f"{place}.{name}".lstrip("."))

    def check_additionalProperties(self, value, schema, parent, place):
        if not isinstance(value, dict):
            return
        for name in value.keys() - parent.get("properties", {}).keys():
            if schema is False:
                self.complain(place, f"{name} is not known")
            elif schema is not True:
                self.check(value[name], schema, f"{place}.{name}".lstrip("."))

    def check_anyOf(self, value, schemas, _, place):
        attempts = []
        for schema in schemas:
            attempt = Checker(self.root)
            attempt.check(value, schema, place)
            attempts.append(attempt.errors)
        if all(attempts):
            self.errors += min(attempts, key=len)

    def check_allOf(self, value, schemas, _, place):
        for schema in schemas:
            self.check(value, schema, place)

    def check_if(self, value, condition, parent, place):
        attempt = Checker(self.root)
        attempt.check(value, condition, place)
        self.check(value, parent.get("else" if attempt.errors else "then", {}), place)

    def check_then(self, *_):
        """Taken with `if`."""

    check_else = check_then


def errors_of(value, schema):
    """What is wrong with a value, in sentences; empty: nothing."""
    checker = Checker(schema)
    checker.check(value, schema, "")
    return checker.errors
