find_package(rapidcheck REQUIRED)
set(workflow_test_dependencies import session diagnosis estimation rapidcheck)
