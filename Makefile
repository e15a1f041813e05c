# Every target works as the first command in a fresh clone: each makes the environment it needs.
PYTHON ?= python3
BIN := .venv/bin
STAMP := .venv/.installed
TRIAL := benchmarks/trial/results
export OPENBLAS_NUM_THREADS ?= 1

.PHONY: setup check test demo serve bench trial docs gallery site validation openapi sync-client page lock

$(STAMP): pyproject.toml requirements.lock
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --editable .
	@touch $@

setup: $(STAMP) ## make .venv with everything

check: setup ## format, lint, types, floors, known vulnerabilities
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	.ci/audit $(BIN)/pip-audit

# Some of the tests start processes, hundreds in all: what they import is compiled once, not by each of them.
# Half of the tests wait for such processes half of their time, so that two cores serve four workers.
test: export PYTHONDONTWRITEBYTECODE :=
test: setup ## the whole test suite, with branch coverage
	$(BIN)/python -m slipcover --json --out coverage.json -m pytest -n 4 --dist loadfile --no-loadscope-reorder $(if $(CI),--durations=25)
	$(BIN)/python -m slipcover --merge coverage.json --out coverage.json --fail-under 95

demo: setup ## chapter 5 of the thesis and a diagnosis, through HTTP
	$(BIN)/modallab demo

serve: setup ## the service on http://127.0.0.1:8000
	$(BIN)/modallab serve

bench: setup ## speed as ratios against a limit or a peer of the same run
	$(BIN)/python -m benchmarks

trial: setup ## the blind trial of the diagnosis, for hours; may be cut and continued; writes docs/trial.md
	mkdir -p $(TRIAL)
	$(BIN)/python -m benchmarks.blind_trial --set 1 --cases 416 --seed 9001 --out $(TRIAL)/1.jsonl --resume
	$(BIN)/python -m benchmarks.blind_trial --set 2 --cases 156 --seed 10001 --out $(TRIAL)/2.jsonl --resume
	$(BIN)/python -m benchmarks.blind_trial --set 3a --cases 156 --types single --seed 10001 --out $(TRIAL)/3a.jsonl --resume
	$(BIN)/python -m benchmarks.blind_trial --set 3 --cases 156 --types pair nothing unknown log_book --seed 10001 \
		--out $(TRIAL)/3.jsonl --resume
	$(BIN)/python -m benchmarks.blind_trial --set 4 --cases 24 --seed 10001 --out $(TRIAL)/4.jsonl --resume
	$(BIN)/python -m benchmarks.blind_trial --out $(TRIAL)/*.jsonl --report docs/trial.md

docs: gallery validation site ## pictures of all effects, the validation report and the site

gallery: setup ## pages and pictures of all effects
	$(BIN)/python -m docs.gallery

site: setup ## the documentation as a site in build/site, strict about links, without Internet
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --quiet

validation: setup ## tables of the thesis beside ours, docs/validation.md
	$(BIN)/python -m docs.validation

openapi: setup ## write docs/openapi.json from the service
	$(BIN)/python -m docs.openapi

sync-client: setup ## write result types from docs/openapi.json, and the synchronous client from the asynchronous one
	$(BIN)/python client/generate_models.py
	$(BIN)/python client/generate_options.py
	$(BIN)/python client/unasync.py

page: ## build the page of the service, with node; its sources are in service/page
	cd service/page && npm ci --no-audit --no-fund && npm run build

lock: setup ## renew requirements.lock
	$(BIN)/python -m pip install --quiet uv
	$(BIN)/uv pip compile --quiet --universal --no-header --no-annotate --extra dev --python-version 3.11 pyproject.toml -o requirements.lock
