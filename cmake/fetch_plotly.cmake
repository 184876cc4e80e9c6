# Fetches Plotly from npm into FOLDER, once. Never fails a build: without it only `mm report` cannot work, and says so;
# why it is not there is one line of FOLDER/plotly_missing.txt.
# cmake -DFOLDER=<build>/web -P cmake/fetch_plotly.cmake

include(${CMAKE_CURRENT_LIST_DIR}/plotly_version.cmake)

function(missing why)
  file(WRITE ${FOLDER}/plotly_missing.txt "${why}\n")
  message(WARNING "${why}: mm report will not work until a build has fetched it")
endfunction()

if(EXISTS ${FOLDER}/plotly.min.js)
  file(SHA256 ${FOLDER}/plotly.min.js found)
  if(found STREQUAL plotly_sha256)
    return()
  endif()
endif()
find_program(NPM npm)
if(NOT NPM)
  missing("npm is not installed (Debian: apt-get install npm)")
  return()
endif()
set(work ${FOLDER}/fetch)
file(REMOVE_RECURSE ${work})
file(MAKE_DIRECTORY ${work})
execute_process(
  COMMAND ${NPM} pack --loglevel=error --fetch-retries=1 --fetch-retry-mintimeout=2000 --fetch-timeout=30000 ${plotly_package}
  WORKING_DIRECTORY ${work} RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE problem TIMEOUT 120)
file(GLOB archive ${work}/*.tgz)
if(NOT status EQUAL 0 OR NOT archive)
  if(problem MATCHES "code ([A-Z0-9_]+)")
    set(status ${CMAKE_MATCH_1})
  endif()
  missing("npm pack ${plotly_package} failed (${status}); can the npm registry be reached? npm ping tells")
  return()
endif()
file(ARCHIVE_EXTRACT INPUT ${archive} DESTINATION ${work} PATTERNS package/plotly.min.js package/LICENSE)
file(SHA256 ${work}/package/plotly.min.js found)
if(NOT found STREQUAL plotly_sha256)
  missing("${plotly_package}: plotly.min.js has sha256 ${found} instead of ${plotly_sha256}; it is not used")
  return()
endif()
file(RENAME ${work}/package/plotly.min.js ${FOLDER}/plotly.min.js)
file(REMOVE_RECURSE ${work} ${FOLDER}/plotly_missing.txt)
