#!/usr/bin/env bash
# The pages' JavaScript: no name that is not there, no wrong argument, and numbers in words as a person writes them.
set -u
said="$(tsc -p test/web/tsconfig.json)" && echo 'ok the workbench is sound to the TypeScript compiler' || echo "not ok the workbench is sound to the TypeScript compiler: $said"
exec node test/web/text_parts.mjs
