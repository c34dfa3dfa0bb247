# Every target is a forward: scripts/bootstrap.py sets .venv up when needed, and also runs without make.
PYTHON3 ?= python3
ARGS ?=

.PHONY: setup demo test check lint docs matrix bench torture format
.NOTPARALLEL:
setup demo test check lint docs matrix bench torture format:
	@$(PYTHON3) scripts/bootstrap.py $@ $(ARGS)
