#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds the types that C++ sources define, and those whose qualified name is defined in more than one file.

Two types of one name in one program break the One Definition Rule without a diagnostic: the linker keeps one of two
member functions or vectors of them. Types in anonymous namespaces and in function bodies are exempt, and so are forward
declarations and aliases that name the same type.
"""

import re
from collections import defaultdict

TOKEN = re.compile(
    r"""//(?:\\\n|[^\n])*|/\*.*?\*/                      # comments
      | ^[ \t]*\#(?:\\\n|[^\n])*                         # preprocessor lines
      | (?:u8|[uUL])?R"(?P<mark>[^()\\\s]*)\(.*?\)(?P=mark)"
      | (?:u8|[uUL])?"(?:\\.|[^"\\\n])*"
      | \.?\d(?:'?[\w.]|(?<=[eEpP])[+-])*                # numbers, 1'000 too
      | (?:u8|[uUL])?'(?:\\.|[^'\\\n])+'
      | (?P<token>[A-Za-z_]\w*|::|\[\[|\]\]|[^\s\w])""",
    re.VERBOSE | re.MULTILINE | re.DOTALL)
CLOSING = {"<": ">", "(": ")", "[[": "]]"}
ANONYMOUS, BODY = "(anonymous)", "(body)"


def tokens_of(text):
    return [match["token"] for match in TOKEN.finditer(text) if match["token"]]


def is_name(token):
    return token[0].isalpha() or token[0] == "_"


def after_bracket(tokens, start):
    """The index after the bracket that opens at `start`; of `<`, those in parentheses are comparisons."""
    opening, depth, at = tokens[start], 0, start
    while at < len(tokens):
        if opening == "<" and tokens[at] == "(":
            at = after_bracket(tokens, at)
            continue
        depth += (tokens[at] == opening) - (tokens[at] == CLOSING[opening])
        at += 1
        if depth == 0:
            return at
    return at


def type_head(tokens, start):
    """After class, struct, union or enum at `start`: the name ("" where there is none) and the index of what follows it
    with its base classes: `{` for a definition."""
    at, name = start + 1, ""
    if tokens[start] == "enum" and tokens[at] in ("class", "struct"):
        at += 1
    while at < len(tokens):
        if tokens[at] == "[[":
            at = after_bracket(tokens, at)
        elif tokens[at] == "alignas":
            at = after_bracket(tokens, at + 1)
        elif tokens[at] == "::" or (is_name(tokens[at]) and (not name or name.endswith("::"))):
            name += tokens[at]
            at += 1
        elif tokens[at] == "<" and name:  # a specialisation is a type of its own
            end = after_bracket(tokens, at)
            name += " ".join(tokens[at:end])
            at = end
        else:
            break
    if tokens[at:at + 1] == ["final"]:
        at += 1
    if tokens[at:at + 1] == [":"]:
        while at < len(tokens) and tokens[at] not in ("{", ";"):
            at += 1
    return name, at


def end_of_statement(tokens, start):
    depth, at = 0, start
    while at < len(tokens) and (tokens[at] != ";" or depth > 0):
        depth += (tokens[at] == "{") - (tokens[at] == "}")
        at += 1
    return at


def types_of(text):
    """(qualified name, what it is) of every type that the source defines where others could define it too: "" for a
    class, structure, union or enumeration, the aliased type for an alias. Throws ValueError where the braces do not
    balance."""
    tokens, scopes, found, at = tokens_of(text), [], [], 0

    def define(name, what):
        if ANONYMOUS not in scopes:
            found.append(("::".join([*scopes, name]), what))

    while at < len(tokens):
        token = tokens[at]
        if token == "}":
            if not scopes:
                raise ValueError("the braces do not balance")
            scopes.pop()
        elif token == "{":
            scopes.append(BODY)
        elif BODY in scopes:
            pass
        elif token == "template" and tokens[at + 1:at + 2] == ["<"]:
            at = after_bracket(tokens, at + 1)
            continue
        elif token == "namespace":
            end = at + 1
            while end < len(tokens) and tokens[end] not in ("{", ";"):
                end = after_bracket(tokens, end) if tokens[end] == "[[" else end + 1
            if tokens[end:end + 1] == ["{"]:
                names = [word for word in tokens[at + 1:end] if is_name(word) and word != "inline"]
                scopes.append("::".join(names) or ANONYMOUS)
            at = end
        elif token == "using":
            end = end_of_statement(tokens, at)
            if tokens[at + 2:at + 3] == ["="]:
                define(tokens[at + 1], " ".join(tokens[at + 3:end]))
            at = end
        elif token == "typedef":
            raise ValueError("write `using NAME = TYPE;` for typedef")
        elif token in ("class", "struct", "union", "enum"):
            name, end = type_head(tokens, at)
            if tokens[end:end + 1] == ["{"]:
                if name:
                    define(name, "")
                scopes.append(name if name and token != "enum" else BODY)
                at = end
        at += 1
    if scopes:
        raise ValueError("the braces do not balance")
    return found


def problems(sources):
    """`sources`: (path, text) of every source of the tree."""
    files, meanings = defaultdict(list), defaultdict(set)
    for path, text in sources:
        try:
            found = types_of(text)
        except ValueError as error:
            yield f"{path}: its types cannot be read: {error}"
            continue
        for name, what in dict.fromkeys(found):
            files[name] += [path]
            meanings[name].add(what)
    for name in sorted(files):
        same_alias = len(meanings[name]) == 1 and "" not in meanings[name]
        if len(set(files[name])) > 1 and not same_alias:
            yield (f"{name}: defined in {' and in '.join(sorted(set(files[name])))}: rename one, or put what one file "
                   "alone uses into an anonymous namespace")
