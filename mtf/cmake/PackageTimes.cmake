# SPDX-License-Identifier: Apache-2.0
# CPack calls it before files become packages: manual pages are compressed, as Debian has them, and all files are of the time
# SOURCE_DATE_EPOCH, so that packages of one commit are the same bytes.

execute_process(COMMAND find "${CPACK_TEMPORARY_DIRECTORY}" -path "*/man/man1/*.1" -exec gzip -9n "{}" + COMMAND_ERROR_IS_FATAL ANY)
if(DEFINED ENV{SOURCE_DATE_EPOCH})
  execute_process(COMMAND find "${CPACK_TEMPORARY_DIRECTORY}" -exec touch --no-dereference "--date=@$ENV{SOURCE_DATE_EPOCH}" "{}" +
    COMMAND_ERROR_IS_FATAL ANY)
endif()
