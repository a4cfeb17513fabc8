# cmake -DLAUNCH=mpirun;-n;3;PROGRAM -DTAG=[tag] -P check_failing_rank.cmake
# The job must end within seconds, not with success, and name the rank and what failed.
string(TIMESTAMP start "%s")
execute_process(COMMAND ${LAUNCH} ${TAG} RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE err TIMEOUT 60)
string(TIMESTAMP end "%s")
math(EXPR seconds "${end} - ${start}")

if(code EQUAL 0)
  message(FATAL_ERROR "the job with a failing rank ended as if all were well\n${out}\n${err}")
endif()
if(seconds GREATER 20)
  message(FATAL_ERROR "the job with a failing rank took ${seconds} s to end\n${out}\n${err}")
endif()
foreach(words IN ITEMS "FAILED on rank 1 of 3" "the planted fault" "failing_rank.cpp:")
  string(FIND "${err}" "${words}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "\"${words}\" is not in what the job printed:\n${out}\n${err}")
  endif()
endforeach()
