"""Reads json_cases.txt and checks the column that says what Python's json does."""

import json
import sys
import urllib.parse


def python_accepts(document):
    try:
        json.loads(document.decode("utf-8"))  # no guessing of encodings
    except (ValueError, RecursionError):
        return False
    return True


def main(path):
    wrong = 0
    count = 0
    with open(path, encoding="ascii") as lines:
        for line in lines:
            if line.startswith("#"):
                continue
            verdict, python, document = line.rstrip("\n").split(" ", 2)
            agrees = python_accepts(urllib.parse.unquote_to_bytes(document)) == (verdict == "accept")
            count += 1
            if agrees != (python == "same"):
                wrong += 1
                print(f"{document}: {verdict}, python {'agrees' if agrees else 'differs'}")
    print(f"{count} documents, {wrong} wrong")
    return 0 if count > 100 and wrong == 0 else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
