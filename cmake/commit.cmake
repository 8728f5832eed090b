# SPDX-License-Identifier: MIT
# cmake -DSOURCE=… -DOUTPUT=… -P commit.cmake: writes the commit into a C file, which stays as it is while the commit does. A
# copy without .git of its own is not taken for part of a repository around it.
set(commit unknown)
find_program(GIT git)
if(GIT AND EXISTS ${SOURCE}/.git)
  execute_process(COMMAND ${GIT} -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
    OUTPUT_VARIABLE text OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE status)
  if(status EQUAL 0 AND text MATCHES "^[0-9a-f]+(-dirty)?$")
    set(commit ${text})
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT
  "/* SPDX-License-Identifier: MIT */\n#include \"program.h\"\n\nconst char program_commit[] = \"${commit}\";\n" @ONLY)
