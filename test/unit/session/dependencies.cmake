set(session_test_dependencies gmock)
