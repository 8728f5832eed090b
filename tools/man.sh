#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The manual page fanal.1 from what the program says of itself: man.sh FANAL
set -eu

# A text as it stands: backslashes and dots at the beginning of lines mean something to roff.
verbatim() { sed -e 's/\\/\\e/g' -e 's/^\([.'\'']\)/\\\&\1/' -e 's/-/\\-/g'; }
section() { printf '.SH %s\n.nf\n' "$1"; verbatim; printf '.fi\n'; }

version=$("$1" --version)
cat <<END
.\\" SPDX-License-Identifier: MIT
.TH FANAL 1 "" "$version" "User Commands"
.SH NAME
fanal \\- renders scenes with thousands of lights, compares the ways to do it and finds the fastest
.SH SYNOPSIS
.B fanal
.I COMMAND
[\\fIOPTIONS\\fR] ...
.br
.B fanal
.I SCENE
END
"$1" --help | section DESCRIPTION
optional=$("$1" --help | sed -n -E 's/^  (view|xr) .*/\1/p') # not in every build
for command in render $optional cave trace bench info devices compare compress; do "$1" "$command" --help | section "fanal $command"; done
"$1" render --options | section "OPTIONS OF A FRAME"
"$1" render --counters | section "COUNTERS"
